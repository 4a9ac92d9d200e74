"""The counts of a tile at its recent ticks: what its later frames are predicted from, the same at both ends."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from .vocabulary import BETWEEN, MAX_DEPTH, SLOWEST_INTERVAL, layer_of

#: All channels of a tile: [channel][z][x].
Counts = NDArray[np.int16]


class History:
    """Bounded: three frames of layer 0 at most, and the newest of layer 1."""

    def __init__(self) -> None:
        self._base: deque[tuple[int, Counts]] = deque(maxlen=MAX_DEPTH)  # the newest first
        self._middle: tuple[int, Counts] | None = None

    def basis(self, tick: int, depth: int) -> list[Counts] | None:
        """What a frame of a depth above 0 is predicted from; None where something of that is not held."""
        if depth == BETWEEN:
            gap = (SLOWEST_INTERVAL >> 1) >> (layer_of(tick) - 1)
            ticks = [tick - gap, tick + gap]
        else:
            ticks = [tick - back * SLOWEST_INTERVAL for back in range(1, depth + 1)]
        found = [counts for at in ticks if (counts := self._at(at)) is not None]
        return found if len(found) == len(ticks) else None

    def keep(self, tick: int, counts: Counts) -> None:
        """Keeps a frame, where others may be predicted from it."""
        layer = layer_of(tick)
        if layer == 0:
            # A frame again, or one of another past: what is newer has nothing to do with it.
            while self._base and self._base[0][0] >= tick:
                self._base.popleft()
            if len(self._base) == MAX_DEPTH:
                self._base.pop()
            self._base.appendleft((tick, counts))
        elif layer == 1:
            self._middle = (tick, counts)

    def _at(self, tick: int) -> Counts | None:
        for held, counts in self._base:
            if held == tick:
                return counts
        if self._middle is not None and self._middle[0] == tick:
            return self._middle[1]
        return None
