"""The header of a binary frame (PROTOCOL.md section 5): every field read, and every wrong one refused."""

from __future__ import annotations

import math
import struct
import zlib
from dataclasses import dataclass
from typing import Final

from .errors import FrameError
from .vocabulary import (
    BETWEEN,
    CLASSES,
    CODECS,
    FLOATS,
    GROUP_NAMES,
    GROUPS,
    LAST_TICK,
    MAX_DEPTH,
    PREDICTING,
    TILE,
    Unit,
    layer_of,
)

HEADER_BYTES: Final = 88
FRAME_MAGIC: Final = b"SWF1"
FLAG_KEY: Final = 1
FLAG_SATURATED: Final = 2

_FORM: Final = struct.Struct("<4sH6B5H2B3Q2I6f2I")
_CRC_AT: Final = 80
#: Beside four bytes a sample, a coded payload is never longer than its tables.
_TABLES_BYTES: Final = 8192
#: The longest frame there can be.
LONGEST_FRAME: Final = HEADER_BYTES + 3 * TILE * TILE * 4 + _TABLES_BYTES


@dataclass(frozen=True, slots=True)
class Header:
    """All that a frame says about its payload."""

    unit: Unit
    flags: int
    n: int
    level_n: int
    tile_x: int
    tile_z: int
    channels: int
    depth: int
    tick: int
    epoch: int
    sequence: int
    layout: int
    step: tuple[float, ...]
    max_error: tuple[float, ...]

    @property
    def samples(self) -> int:
        """Samples of all channels of this tile."""
        return self.channels * self.n * self.n


def read_header(frame: bytes) -> Header:
    """Reads and checks a header, the length of the payload and the checksum of both; raises FrameError."""
    if len(frame) < HEADER_BYTES:
        raise FrameError(f"frame is {len(frame)} bytes, a header alone is {HEADER_BYTES}")
    magic, header_bytes, cascade, level, error, group, codec, flags, *rest = _FORM.unpack_from(frame)
    n, level_n, tile_x, tile_z, channels, depth, zero_23, tick, epoch, sequence, layout, payload, *rest = rest
    step, max_error, crc, zero_84 = tuple(rest[0:3]), tuple(rest[3:6]), rest[6], rest[7]

    _must(magic == FRAME_MAGIC, "magic", magic, "SWF1")
    _must(header_bytes == HEADER_BYTES, "header_bytes", header_bytes, str(HEADER_BYTES))
    _must(error < len(CLASSES), "class", error, f"below {len(CLASSES)}")
    _must(group < len(GROUP_NAMES), "group", group, f"below {len(GROUP_NAMES)}")
    _must(codec < len(CODECS), "codec", codec, f"below {len(CODECS)}")
    _must(flags & ~(FLAG_KEY | FLAG_SATURATED) == 0, "flags", flags, "0 to 3")
    unit = Unit(cascade, level, CLASSES[error], GROUP_NAMES[group], CODECS[codec])

    _must(8 <= n <= TILE and n & (n - 1) == 0, "n", n, f"a power of two, 8 to {TILE}")
    whole = level_n == n or (n == TILE and level_n > n and level_n % n == 0)
    _must(whole, "level_n", level_n, f"n, or a multiple of {TILE} where n is that")
    _must(tile_x < level_n // n, "tile_x", tile_x, f"below {level_n // n}")
    _must(tile_z < level_n // n, "tile_z", tile_z, f"below {level_n // n}")
    expected = len(GROUPS[unit.group])
    _must(channels == expected, "channels", channels, f"{expected} of {unit.group}")
    _must(zero_23 == 0, "byte 23", zero_23, "0")
    _must(zero_84 == 0, "bytes 84 to 87", zero_84, "0")
    _must(tick <= LAST_TICK, "tick", tick, "at most 2^53 - 1")
    _must(flags & FLAG_KEY == 0 or depth == 0, "depth", depth, "0 in a key frame")
    _must(_depth_fits(depth, unit.codec, tick), "depth", depth, f"one that {unit.codec} has at tick {tick}")

    for c in range(3):
        if c >= channels:
            _must(step[c] == 0, f"step[{c}]", step[c], "0: there is no such channel")
            _must(max_error[c] == 0, f"max_error[{c}]", max_error[c], "0: there is no such channel")
            continue
        _must(_positive(step[c]), f"step[{c}]", step[c], "finite and above 0")
        if unit.codec == "f32":
            _must(max_error[c] == 0, f"max_error[{c}]", max_error[c], "0: it is the field itself")
        else:
            _must(_positive(max_error[c]), f"max_error[{c}]", max_error[c], "finite and above 0")

    least, most = _payload_range(unit.codec, channels * n * n)
    _must(least <= payload <= most, "payload_bytes", payload, f"{least} to {most}")
    _must(len(frame) == HEADER_BYTES + payload, "length", len(frame), f"{HEADER_BYTES + payload}")
    computed = zlib.crc32(memoryview(frame)[HEADER_BYTES:], zlib.crc32(frame[:_CRC_AT]))
    _must(crc == computed, "crc", f"{crc:#010x}", f"{computed:#010x}")
    return Header(
        unit, flags, n, level_n, tile_x, tile_z, channels, depth, tick, epoch, sequence, layout,
        step[:channels], max_error[:channels],
    )  # fmt: skip


def _depth_fits(depth: int, codec: str, tick: int) -> bool:
    """Frames of a layer are predicted from layers below it alone."""
    if depth == 0:
        return True
    if codec not in PREDICTING:
        return False
    layer = layer_of(tick)
    return depth <= MAX_DEPTH if layer == 0 else layer < 3 and depth == BETWEEN


def _payload_range(codec: str, samples: int) -> tuple[int, int]:
    if codec in PREDICTING:
        return 1, samples * 4 + _TABLES_BYTES
    size = samples * (4 if codec == "f32" else 2)
    assert codec == "i16" or codec in FLOATS
    return size, size


def _positive(value: float) -> bool:
    return 0 < value < math.inf


def _must(holds: bool, field: str, value: object, bound: str) -> None:
    if not holds:
        raise FrameError(f"{field} is {value}, must be {bound}")
