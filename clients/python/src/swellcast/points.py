"""Messages of points (PROTOCOL.md section 9): the water at fixed points of the world."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .errors import FrameError
from .vocabulary import LAST_TICK, TICKS_PER_SECOND

POINTS_MAGIC: Final = b"SWP1"
_FORM: Final = struct.Struct("<4s2H2I4Q2I")
_CRC_AT: Final = 48
_RECORD: Final = np.dtype([("numbers", "<f4", (9,)), ("flags", "<u4")])
_FLAGS: Final = 7


@dataclass(frozen=True, eq=False)
class PointsFrame:
    """The water at all points at one tick, in the order asked. What the scene doesn't have is None."""

    tick: int
    epoch: int
    sequence: int
    id: int
    #: Of the displaced surface above each point, metres.
    height: NDArray[np.float32]
    #: Unit vectors (east, up, south), [point][3].
    normal: NDArray[np.float32] | None
    #: Of the water particle there, m/s, [point][3].
    velocity: NDArray[np.float32] | None
    jacobian: NDArray[np.float32] | None
    #: Distance between the point and where the particle found is, metres.
    residual: NDArray[np.float32]
    folded: NDArray[np.bool_]

    @property
    def time_s(self) -> float:
        """Seconds since the sea began."""
        return self.tick / TICKS_PER_SECOND


def read_points(message: bytes) -> PointsFrame:
    """Reads a message, checked in every field, by its length and by its checksum; raises FrameError."""
    if len(message) < _FORM.size:
        raise FrameError(f"points are {len(message)} bytes, a header alone is {_FORM.size}")
    magic, header_bytes, record_bytes, count, flags, tick, epoch, sequence, id, crc, zero = _FORM.unpack_from(message)
    _must(magic == POINTS_MAGIC, "magic", magic, "SWP1")
    _must(header_bytes == _FORM.size, "header_bytes", header_bytes, f"{_FORM.size}")
    _must(record_bytes == _RECORD.itemsize, "record_bytes", record_bytes, f"{_RECORD.itemsize}")
    _must(len(message) == _FORM.size + count * _RECORD.itemsize, "count", count, f"what {len(message)} bytes hold")
    _must(flags & ~_FLAGS == 0, "flags", flags, f"0 to {_FLAGS}")
    _must(tick <= LAST_TICK, "tick", tick, "at most 2^53 - 1")
    _must(id <= LAST_TICK, "id", id, "at most 2^53 - 1")
    _must(zero == 0, "bytes 52 to 55", zero, "0")
    computed = zlib.crc32(memoryview(message)[_FORM.size :], zlib.crc32(message[:_CRC_AT]))
    _must(crc == computed, "crc", f"{crc:#010x}", f"{computed:#010x}")
    records = np.frombuffer(message, _RECORD, count, _FORM.size)
    numbers = records["numbers"].astype(np.float32)
    _must(bool(np.isfinite(numbers).all()), "a number of a point", "not finite", "finite")
    _must(bool((records["flags"] <= 1).all()), "flags of a point", int(records["flags"].max(initial=0)), "0 or 1")
    return PointsFrame(
        tick,
        epoch,
        sequence,
        id,
        height=numbers[:, 0],
        normal=numbers[:, 1:4] if flags & 1 else None,
        velocity=numbers[:, 4:7] if flags & 2 else None,
        jacobian=numbers[:, 7] if flags & 4 else None,
        residual=numbers[:, 8],
        folded=records["flags"] == 1,
    )


def _must(holds: bool, field: str, value: object, bound: str) -> None:
    if not holds:
        raise FrameError(f"{field} is {value}, must be {bound}")
