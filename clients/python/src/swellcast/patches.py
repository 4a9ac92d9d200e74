"""Puts the tiles of a patch of more than 256 samples a side together.

Bounded: of a unit, the newest few ticks that lack tiles are held, and no more samples in all than it is made for.
What never becomes whole is dropped, and counted.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .decode import Tile
from .frame import Frame
from .header import FLAG_SATURATED, Header
from .vocabulary import Unit

#: Ticks of one unit that are put together at a time: those of one tick leave the server together.
_MOST_PARTIAL: Final = 4


class Patches:
    """Tiles in, whole frames out."""

    def __init__(self, most_samples: int) -> None:
        self._most_samples = most_samples
        self._partial: dict[tuple[Unit, int], dict[tuple[int, int], Tile]] = {}
        self._samples = 0
        #: Frames that were dropped because not all their tiles came.
        self.incomplete = 0

    def add(self, tile: Tile) -> Frame | None:
        """The whole frame, where this was its last tile."""
        header = tile.header
        side = header.level_n // header.n
        if side == 1:
            return Frame.of(header, tile.counts, tile.floats)
        key = (header.unit, header.tick)
        tiles = self._partial.setdefault(key, {})
        if any(other.header.epoch != header.epoch or other.header.level_n != header.level_n for other in tiles.values()):
            # Of another sea, or another patch: what came before belongs to nothing.
            self._drop(key)
            tiles = self._partial.setdefault(key, {})
        if (header.tile_x, header.tile_z) not in tiles:
            self._samples += header.samples
        tiles[header.tile_x, header.tile_z] = tile
        if len(tiles) == side * side:
            self._forget(key)
            return _joined(tiles)
        self._keep_bounds(header.unit)
        return None

    def clear(self) -> None:
        """Forgets everything: another sea begins."""
        self._partial.clear()
        self._samples = 0

    def _keep_bounds(self, unit: Unit) -> None:
        of_unit = [key for key in self._partial if key[0] == unit]
        if len(of_unit) > _MOST_PARTIAL:
            self._drop(of_unit[0])
        while self._samples > self._most_samples:
            self._drop(next(iter(self._partial)))

    def _drop(self, key: tuple[Unit, int]) -> None:
        self._forget(key)
        self.incomplete += 1

    def _forget(self, key: tuple[Unit, int]) -> None:
        self._samples -= sum(tile.header.samples for tile in self._partial.pop(key).values())


def _joined(tiles: dict[tuple[int, int], Tile]) -> Frame:
    first = next(iter(tiles.values()))
    header = first.header
    shape = (header.channels, header.level_n, header.level_n)
    counts: NDArray[np.int16] | None = None if first.counts is None else np.empty(shape, np.int16)
    floats: NDArray[np.float32] | None = None if first.floats is None else np.empty(shape, np.float32)
    for (x, z), tile in tiles.items():
        rows = slice(z * header.n, (z + 1) * header.n)
        columns = slice(x * header.n, (x + 1) * header.n)
        if counts is not None and tile.counts is not None:
            counts[:, rows, columns] = tile.counts
        if floats is not None and tile.floats is not None:
            floats[:, rows, columns] = tile.floats
    return Frame.of(_weakest([tile.header for tile in tiles.values()]), counts, floats)


def _weakest(headers: list[Header]) -> Header:
    """A header that holds for all tiles: saturated where any is, with the largest error of any."""
    flags = headers[0].flags
    for header in headers[1:]:
        flags |= header.flags & FLAG_SATURATED
    errors = tuple(max(channel) for channel in zip(*(header.max_error for header in headers), strict=True))
    return replace(headers[0], flags=flags, max_error=errors)
