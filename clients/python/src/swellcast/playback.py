"""The water between frames: the recent frames of each unit, interpolated at any server time.

Frames of a unit lie on an absolute grid of ticks and come in any order. The four around a time are joined by the
Lagrange cubic through them, fewer at the edges. Never beyond the last frame: it is held, and said to be starved.

Bounded: so many frames of each cascade and group, and no more samples of one moment than there may be.
"""

from __future__ import annotations

from bisect import bisect_right, insort
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .frame import Frame
from .messages import Cascade, Hello
from .vocabulary import GROUPS, MOST_SAMPLES, REST_TICKS, SLOWEST_INTERVAL, TICKS_PER_SECOND

#: At 60 Hz the server is 14 frames ahead, and a curve needs two behind: at most eight intervals away, where only frames
#: of 15 Hz come.
RING: Final = 24
#: How far apart frames may lie and still be joined by a curve.
_MOST_GAP: Final = 3 * SLOWEST_INTERVAL


@dataclass(frozen=True, eq=False, slots=True)
class Sample:
    """The water of one cascade and group at a moment: [channel][z][x]."""

    planes: NDArray[np.float32]
    channels: tuple[str, ...]
    #: The moment lies outside the frames that are held: this is the nearest of them.
    starved: bool

    def __getitem__(self, channel: str) -> NDArray[np.float32]:
        """The plane of a channel by its name."""
        plane: NDArray[np.float32] = self.planes[self.channels.index(channel)]
        return plane


@dataclass(slots=True)
class _Ring:
    """The frames of one cascade, group and level."""

    level: int
    samples: int
    ticks: list[int] = field(default_factory=list)  # in order
    frames: dict[int, Frame] = field(default_factory=dict)

    def add(self, frame: Frame) -> None:
        if frame.tick not in self.frames:
            insort(self.ticks, frame.tick)
        self.frames[frame.tick] = frame
        if len(self.ticks) > RING:
            del self.frames[self.ticks.pop(0)]


class Playback:
    """The recent frames of a subscription."""

    def __init__(self) -> None:
        self._cascades: dict[int, Cascade] = {}
        # By cascade and group: the level that is shown, and one that will take over once its frames reach back so far.
        self._rings: dict[tuple[int, str], list[_Ring]] = {}

    def begin(self, hello: Hello, same_sea: bool) -> None:
        """Takes a `hello`: of the same sea, what is held of cascades that go on stays."""
        cascades = {cascade.index: cascade for cascade in hello.layout.cascades}
        for key in list(self._rings):
            old, new = self._cascades.get(key[0]), cascades.get(key[0])
            if not same_sea or old is None or new is None or (old.from_tick, old.n) != (new.from_tick, new.n):
                del self._rings[key]
        self._cascades = cascades

    def retain(self, wanted: set[tuple[int, str]]) -> None:
        """Forgets cascades and groups that are not wanted any more."""
        self._rings = {key: rings for key, rings in self._rings.items() if key in wanted}

    def add(self, frame: Frame) -> None:
        """Keeps a frame. One that is held already is replaced."""
        key = (frame.unit.cascade, frame.unit.group)
        rings = self._rings.setdefault(key, [])
        ring = next((ring for ring in rings if ring.level == frame.unit.level), None)
        if ring is None:
            held = sum(ring.samples for rings in self._rings.values() for ring in rings)
            if held + frame.data.size > 2 * MOST_SAMPLES:
                return
            ring = _Ring(frame.unit.level, frame.data.size)
            rings.append(ring)
            if len(rings) > 2:
                del rings[0]
        ring.add(frame)

    def ticks(self, cascade: int, group: str) -> list[int]:
        """The ticks held of a unit, oldest first."""
        rings = self._rings.get((cascade, group), [])
        return sorted({tick for ring in rings for tick in ring.ticks})

    def sample(self, time_s: float) -> dict[tuple[int, str], Sample]:
        """The water at a server time, seconds since tick 0, by index of the cascade and name of the group.

        Cascades that are no part of the sea then, or of which no frame is held, are not there: they count as nothing.
        """
        found = {}
        for cascade, group in list(self._rings):
            sample = self.sample_of(cascade, group, time_s)
            if sample is not None:
                found[cascade, group] = sample
        return found

    def sample_of(self, cascade: int, group: str, time_s: float) -> Sample | None:
        """The same of one cascade and group."""
        now = time_s * TICKS_PER_SECOND
        life = self._cascades.get(cascade)
        if life is None or (now >= 0 and not life.contains(now)):
            return None
        ring = self._ring(cascade, group, now)
        if ring is None:
            return None
        nodes, starved = _nodes(ring.ticks, now, life.until_tick)
        weights = lagrange([tick - now for tick in nodes])
        planes = ring.frames[nodes[0]].values(weights[0])
        for tick, weight in zip(nodes[1:], weights[1:], strict=True):
            planes += ring.frames[tick].values(weight)
        return Sample(planes, GROUPS[group], starved)

    def _ring(self, cascade: int, group: str, now: float) -> _Ring | None:
        """The frames to show; those of a level that came later once they reach back to the moment."""
        rings = self._rings.get((cascade, group))
        if not rings:
            return None
        if len(rings) > 1 and rings[1].ticks[0] <= now:
            del rings[0]
        return rings[0]


def _nodes(ticks: Sequence[int], now: float, until: int | None) -> tuple[list[int], bool]:
    """The ticks that a curve at a moment goes through, and whether the moment lies outside of them."""
    after = bisect_right(ticks, now)
    if after == 0:
        return [ticks[0]], True
    nearest = ticks[after - 1]
    if nearest == now:
        return [nearest], False
    if after == len(ticks):
        # The last frames before a cascade ends are zero: there is nothing to wait for.
        rests = until is not None and nearest >= until - REST_TICKS
        return [nearest], not rests
    nodes = [nearest, ticks[after]]
    if nodes[1] - nodes[0] > _MOST_GAP:
        return nodes, False
    if after >= 2 and nodes[0] - ticks[after - 2] <= _MOST_GAP:
        nodes.insert(0, ticks[after - 2])
    if after + 1 < len(ticks) and ticks[after + 1] - nodes[-1] <= _MOST_GAP:
        nodes.append(ticks[after + 1])
    return nodes, False


def lagrange(nodes: Sequence[float]) -> list[float]:
    """Weights of values at nodes (different, relative to now) of the polynomial through them, now."""
    weights = []
    for i, node in enumerate(nodes):
        weight = 1.0
        for j, other in enumerate(nodes):
            if i != j:
                weight *= other / (other - node)
        weights.append(weight)
    return weights
