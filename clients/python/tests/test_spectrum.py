"""Spectra of heights that are known."""

from __future__ import annotations

import math
import unittest

import numpy as np

from swellcast.spectrum import Dispersion, Energies, Spectrum, bins


class Spectra(unittest.TestCase):
    def test_a_wave_has_half_its_squared_amplitude_at_its_frequency(self) -> None:
        n, patch, dispersion = 64, 100.0, Dispersion()
        x = np.arange(n) * patch / n
        for mx, mz in ((3, 0), (0, 5), (4, -7), (32, 1)):
            energies = Energies(patch)
            phase = 2 * math.pi * (mx * x[None, :] + mz * x[:, None]) / patch
            for turn in (0.0, 0.3, 0.9):
                energies.add((0.7 * np.cos(phase + turn) + 5.0).astype(np.float32))
            spectrum = Spectrum.of([energies], dispersion)
            self.assertAlmostEqual(float(spectrum.energy_m2.sum()), 0.7**2 / 2, 5)
            self.assertAlmostEqual(spectrum.hs_m, 4 * 0.7 / math.sqrt(2), 5)
            k = 2 * math.pi * math.hypot(mx, mz) / patch
            found = spectrum.frequency_hz[np.argmax(spectrum.energy_m2)]
            self.assertAlmostEqual(float(found), math.sqrt(9.81 * k) / (2 * math.pi), 6)

    def test_energies_add_up_to_the_variance(self) -> None:
        heights = np.random.default_rng(1).normal(size=(32, 32)).astype(np.float32)
        energies = Energies(50.0)
        energies.add(heights)
        modes = energies.modes(Dispersion())[1]
        self.assertAlmostEqual(float(modes.sum()), float(heights.var(dtype=np.float64)), 9)

    def test_dispersion_feels_the_bottom_and_tension(self) -> None:
        k = np.array([0.1, 400.0])
        shallow = Dispersion(depth_m=1.0).frequency_hz(k)
        self.assertAlmostEqual(float(shallow[0]), math.sqrt(0.981 * math.tanh(0.1)) / (2 * math.pi), 9)
        tense = Dispersion(tension=7.3e-5).frequency_hz(k)
        self.assertGreater(float(tense[1]), 1.4 * float(Dispersion().frequency_hz(k)[1]))

    def test_peak_and_density(self) -> None:
        edges = bins()
        middle = np.sqrt(edges[1:] * edges[:-1])
        energy = np.exp(-(((np.log(middle) - math.log(0.125)) / 0.2) ** 2)) * np.diff(edges)
        spectrum = Spectrum(middle, energy)
        self.assertAlmostEqual(spectrum.peak_s(edges), 8.0, 0)
        self.assertAlmostEqual(float((spectrum.density(edges) * np.diff(edges)).sum()), float(energy.sum()), 12)
        self.assertTrue(math.isnan(Spectrum(middle, 0 * energy).peak_s(edges)))


if __name__ == "__main__":
    unittest.main()
