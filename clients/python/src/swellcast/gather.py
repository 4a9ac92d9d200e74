"""Gathers heights of a running sea: for spectra, maps and series."""

from __future__ import annotations

import asyncio
import math
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .errors import SwellcastError
from .frame import Frame
from .messages import Cascade
from .ocean import Ocean
from .reading import Fields
from .spectrum import Dispersion, Energies, Spectrum

#: Ticks between frames that are transformed: half a second, in which short waves have become others.
_TRANSFORM_TICKS: Final = 3600


@dataclass(slots=True)
class Gathered:
    """What was gathered: energies of modes, the newest frame of each cascade, and heights at one point."""

    cascades: dict[int, Cascade] = field(default_factory=dict)
    energies: dict[int, Energies] = field(default_factory=dict)
    newest: dict[int, Frame] = field(default_factory=dict)
    #: By tick, then cascade: height of the particle that rests at the point.
    at_point: dict[int, dict[int, float]] = field(default_factory=dict)

    def spectrum(self, dispersion: Dispersion) -> Spectrum:
        """The spectrum of all cascades."""
        return Spectrum.of(list(self.energies.values()), dispersion)

    def series(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Times (s) and heights (m) at the point, of ticks of which every cascade came."""
        whole = {t: sum(heights.values()) for t, heights in self.at_point.items() if heights.keys() == self.cascades.keys()}
        ticks = sorted(whole)
        return np.array(ticks, np.float64) / 7200, np.array([whole[tick] for tick in ticks])

    def map(self, samples: int) -> tuple[float, NDArray[np.float64]]:
        """Heights over rest positions of a square, [z][x], and its side: a few of the longest waves that matter."""
        side = 6 * self._longest_m()
        places = np.arange(samples, dtype=np.float64) * (side / samples)
        heights = np.zeros((samples, samples))
        for index, frame in self.newest.items():
            at: NDArray[np.float64] = places / self.cascades[index].patch_m * frame.n
            heights += _between(frame["height"].astype(np.float64), at)
        return side, heights

    def _longest_m(self) -> float:
        """The length of the waves of most energy."""
        most = max(self.energies.items(), key=lambda item: float(item[1].modes(Dispersion())[1].sum()))
        frequency, energy = most[1].modes(Dispersion())
        peak = float((frequency * energy**2).sum() / max(float((energy**2).sum()), 1e-300))
        return 9.81 / (2 * math.pi * peak**2) if peak > 0 else most[1].patch_m / 6


async def gather(ocean: Ocean, seconds: float, point: tuple[float, float] = (0.0, 0.0)) -> Gathered:
    """Gathers for so long; `point` is x, z of a place at rest, metres. Raises SwellcastError when the sea changes."""
    group = "height" if any(group.name == "height" for group in ocean.hello.groups) else "displacement"
    await ocean.subscribe(group, error="0.5mm")
    found = Gathered({cascade.index: cascade for cascade in ocean.hello.layout.cascades})
    epoch, generation = ocean.hello.epoch, ocean.hello.layout.generation
    begin: int | None = None
    async with asyncio.timeout(seconds + 30):
        async for frame in ocean:
            if (ocean.hello.epoch, ocean.hello.layout.generation) != (epoch, generation):
                raise SwellcastError("the sea became another while it was measured: measure again")
            begin = frame.tick if begin is None else begin
            index, height = frame.unit.cascade, frame["height"]
            cascade = found.cascades[index]
            if (frame.tick - begin) % _TRANSFORM_TICKS == 0:
                found.energies.setdefault(index, Energies(cascade.patch_m)).add(height)
                found.newest[index] = frame
            x, z = (np.array([metres / cascade.patch_m * frame.n]) for metres in point)
            at = _between(height.astype(np.float64), x, z)
            found.at_point.setdefault(frame.tick, {})[index] = float(at[0, 0])
            if frame.tick - begin > seconds * 7200 and found.energies.keys() == found.cascades.keys():
                return found
    raise SwellcastError("the sea ended while it was measured")


async def dispersion_of(ocean: Ocean) -> Dispersion:
    """The dispersion of the sea that is served: its depth, gravity and surface tension."""
    told = Fields("scene", await ocean.scene())
    state, water = told.one("state", lambda f: f), told.one("scene", lambda f: f.one("water", lambda g: g))
    law = water.text("dispersion")
    depth = math.inf if law == "deep" or state.is_null("depth_m") else state.number("depth_m", above=0)
    tension = water.number("surface_tension") / water.number("density", above=0) if law == "capillary" else 0.0
    return Dispersion(depth, state.number("gravity", above=0), tension)


def _between(
    plane: NDArray[np.float64], x: NDArray[np.float64], z: NDArray[np.float64] | None = None
) -> NDArray[np.float64]:
    """Values between samples, [z][x], by straight lines; the plane repeats for ever. Places are in samples."""
    n = plane.shape[0]
    z = x if z is None else z
    ix, iz = np.floor(x).astype(np.int64), np.floor(z).astype(np.int64)
    fx, fz = (x - ix)[None, :], (z - iz)[:, None]
    left, right, above, below = ix % n, (ix + 1) % n, iz % n, (iz + 1) % n
    upper = plane[np.ix_(above, left)] * (1 - fx) + plane[np.ix_(above, right)] * fx
    lower = plane[np.ix_(below, left)] * (1 - fx) + plane[np.ix_(below, right)] * fx
    between: NDArray[np.float64] = upper * (1 - fz) + lower * fz
    return between
