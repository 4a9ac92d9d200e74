"""What the counts of a plane are predicted to be from other frames (PROTOCOL.md section 10), all samples at once.

All arithmetic is of 32-bit integers that wrap, as NumPy's arrays do; neighbours are looked for around the edges.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .vocabulary import BETWEEN

Plane = NDArray[np.int16]
Predicted = NDArray[np.int32]
#: The eight taps of a plane.
Taps = tuple[int, ...]


def predict_in_time(depth: int, planes: Sequence[Plane], taps: Taps) -> Predicted:
    """The prediction of each sample, in units of 2^-12 counts.

    `planes` are the frames before, the newest first, as many as `depth` says; or at depth 4 both neighbours.
    """
    w = [np.int32(tap) for tap in taps]
    first = planes[0].astype(np.int32)
    across = first + planes[1] if depth == BETWEEN else first
    predicted = across * w[0]
    # Rolled by one, a sample's place holds its neighbour to the west (north).
    for shift, axis, tap in ((1, 1, w[1]), (-1, 1, w[2]), (1, 0, w[3]), (-1, 0, w[4])):
        if tap != 0:
            predicted += np.roll(across, shift, axis) * tap
    predicted += (first * w[7]) >> 4
    if depth == BETWEEN:
        predicted += np.multiply(planes[1], w[7], dtype=np.int32) >> 4
    else:
        for plane, tap in zip(planes[1:], w[5:7], strict=False):
            predicted += np.multiply(plane, tap, dtype=np.int32)
    return predicted


def predict_above(plane: Plane, taps: Taps, z: int) -> list[int]:
    """What the rows above say of row `z`, without what its own row adds; all of it for the first column.

    The first row has nothing above it. Sums wrap; who adds to them keeps the lower 32 bits alone.
    """
    n = plane.shape[1]
    if z == 0:
        return [0] * n
    north = plane[z - 1].astype(np.int32)
    far = plane[z - 2].astype(np.int32) if z > 1 else north
    north_west = np.roll(north, 1)
    north_east = np.roll(north, -1)
    north_east[-1] = north[-1]
    w = [np.int32(tap) for tap in taps]
    above = north * w[1] + north_west * w[2] + north_east * w[3] + far * w[5]
    above[0] = int(north[0]) << 12
    result: list[int] = above.tolist()
    return result
