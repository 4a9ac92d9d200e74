"""Counts from the residuals of codec 2 (PROTOCOL.md section 10)."""

from __future__ import annotations

import zlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .errors import PayloadError
from .predict import Plane, Taps, predict_in_time


def inflated(stream: bytes, size: int) -> bytes:
    """What a raw deflate stream holds, which must be exactly so many bytes; what stands behind it has no meaning."""
    inflater = zlib.decompressobj(-zlib.MAX_WBITS)
    try:
        # One byte more than there may be, so that a stream of more is seen, and never all of it.
        residuals = inflater.decompress(stream, size + 1)
    except zlib.error as error:
        raise PayloadError(f"payload: no deflate stream: {error}") from None
    if len(residuals) != size or not inflater.eof:
        raise PayloadError(f"payload: {len(residuals)} bytes of residuals or no end of them, must be {size}")
    return residuals


def restore_plane(
    low: NDArray[np.uint8], high: NDArray[np.uint8] | None, depth: int, planes: Sequence[Plane], taps: Taps, n: int
) -> NDArray[np.int16]:
    """A plane of n x n counts from the bytes of its residuals."""
    folded = low.astype(np.uint16)
    if high is not None:
        folded |= high.astype(np.uint16) << np.uint16(8)
    residuals = ((folded >> np.uint16(1)) ^ (-(folded & np.uint16(1)).astype(np.int16)).astype(np.uint16)).view(np.int16)
    residuals = residuals.reshape(n, n)
    if depth == 0:
        # West + north - north-west, undone by a sum along each row and one down each column; sums wrap at 16 bits.
        return np.cumsum(np.cumsum(residuals, axis=1, dtype=np.int16), axis=0, dtype=np.int16)
    nearest = (predict_in_time(depth, planes, taps) + np.int32(2048)) >> np.int32(12)
    return (nearest + residuals).astype(np.int16)
