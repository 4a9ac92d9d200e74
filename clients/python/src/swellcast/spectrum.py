"""Wave spectra of streamed heights: a 2D transform of each patch, averaged over frames, by frequency.

A cascade is a square, periodic patch whose heights over the rest positions are a sum of modes, so its transform gives
the energy of each mode exactly; which frequency a mode has is what dispersion says of its wavenumber. Cascades hold
different waves: their energies add.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Dispersion:
    """How fast a wave of a length turns: w^2 = (g k + tension k^3) tanh(k depth); deep where the depth is infinite."""

    depth_m: float = math.inf
    gravity: float = 9.81
    #: Surface tension over density, m^3/s^2; felt below centimetres.
    tension: float = 0.0

    def frequency_hz(self, wavenumber: Floats) -> Floats:
        """Of wavenumbers in rad/m."""
        bottom = np.tanh(wavenumber * self.depth_m) if math.isfinite(self.depth_m) else 1.0
        omega2 = (self.gravity * wavenumber + self.tension * wavenumber**3) * bottom
        frequency: Floats = np.sqrt(omega2) / (2 * math.pi)
        return frequency


class Energies:
    """The mean energy of each mode of one cascade, over the frames that are added."""

    def __init__(self, patch_m: float) -> None:
        self.patch_m = patch_m
        self.frames = 0
        self._sum: Floats | None = None

    def add(self, heights: NDArray[np.float32]) -> None:
        """Adds a frame, [z][x] in metres."""
        modes = np.abs(np.fft.rfft2(heights.astype(np.float64)) / heights.size) ** 2
        # Half of the modes are not there: they are the mirrored ones.
        modes[:, 1 : modes.shape[1] - 1] *= 2
        modes[0, 0] = 0.0
        if self._sum is None or self._sum.shape != modes.shape:
            self._sum, self.frames = np.zeros_like(modes), 0
        self._sum += modes
        self.frames += 1

    def modes(self, dispersion: Dispersion) -> tuple[Floats, Floats]:
        """Frequency (Hz) and energy (m^2) of each mode; the energies add up to the variance of the heights."""
        if self._sum is None:
            raise ValueError("no frame was added")
        n = self._sum.shape[0]
        step = 2 * math.pi / self.patch_m
        kz = np.fft.fftfreq(n, 1 / n) * step
        kx = np.arange(self._sum.shape[1]) * step
        frequency = dispersion.frequency_hz(np.hypot(kx[None, :], kz[:, None]))
        return frequency.ravel(), self._sum.ravel() / self.frames


@dataclass(frozen=True, eq=False, slots=True)
class Spectrum:
    """Energies of modes by frequency."""

    frequency_hz: Floats
    energy_m2: Floats

    @staticmethod
    def of(cascades: list[Energies], dispersion: Dispersion) -> Spectrum:
        """The sum of cascades."""
        parts = [cascade.modes(dispersion) for cascade in cascades]
        return Spectrum(np.concatenate([f for f, _ in parts]), np.concatenate([e for _, e in parts]))

    @property
    def hs_m(self) -> float:
        """Significant wave height, 4 times the standard deviation of the heights."""
        return 4 * math.sqrt(float(self.energy_m2.sum()))

    def density(self, edges: Floats) -> Floats:
        """S(f), m^2/Hz, in bins with these edges."""
        return self.energy(edges) / np.diff(edges)

    def energy(self, edges: Floats) -> Floats:
        """Energy in bins with these edges, m^2."""
        found: Floats = np.histogram(self.frequency_hz, edges, weights=self.energy_m2)[0]
        return found

    def scatter(self, edges: Floats) -> Floats:
        """How far the energy of each bin may be from what is expected of it, as a share: one standard deviation.

        Amplitudes of modes are drawn at random, once; a bin of few modes holds what luck gave it.
        """
        squares = np.histogram(self.frequency_hz, edges, weights=self.energy_m2**2)[0]
        with np.errstate(invalid="ignore", divide="ignore"):
            # The square of an energy that is drawn from an exponential distribution is twice its mean's, on average.
            found: Floats = np.sqrt(squares / 2) / self.energy(edges)
        return found

    def peak_s(self, edges: Floats) -> float:
        """Peak period, seconds: of the mean frequency weighed by S^4 (Young 1995), which few modes don't throw off."""
        middles, weights = np.sqrt(edges[1:] * edges[:-1]), self.density(edges) ** 4 * np.diff(edges)
        total = float(weights.sum())
        return total / float((middles * weights).sum()) if total > 0 else math.nan


def bins(lowest_hz: float = 0.02, highest_hz: float = 5.0, ratio: float = 1.05) -> Floats:
    """Edges of bins, each so many times the one before."""
    count = math.ceil(math.log(highest_hz / lowest_hz) / math.log(ratio))
    edges: Floats = lowest_hz * ratio ** np.arange(count + 1, dtype=np.float64)
    return edges
