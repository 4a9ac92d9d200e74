"""What tests share: the vectors of the repository, and frames built straight from the table in PROTOCOL.md."""

from __future__ import annotations

import json
import struct
import zlib
from pathlib import Path
from typing import Any

VECTORS = Path(__file__).resolve().parents[3] / "proto" / "vectors"
EPOCH = 0xAB54A98CEB1F0AD2
CHANNELS = (3, 2, 3, 1, 1, 3, 2, 2, 2)


def read_json(name: str) -> Any:
    """A JSON file of the vectors."""
    return json.loads((VECTORS / name).read_text())


def read_bytes(name: str) -> bytes:
    """A binary file of the vectors."""
    return (VECTORS / name).read_bytes()


def split_stream(data: bytes) -> list[bytes]:
    """The frames of a file of frames: each stands after its length, a u32."""
    frames, at = [], 0
    while at < len(data):
        (length,) = struct.unpack_from("<I", data, at)
        frames.append(data[at + 4 : at + 4 + length])
        at += 4 + length
    return frames


def sealed(frame: bytes | bytearray) -> bytes:
    """A frame with the checksum that fits its bytes."""
    sealed = bytearray(frame)
    struct.pack_into("<I", sealed, 80, zlib.crc32(sealed[88:], zlib.crc32(sealed[:80])))
    return bytes(sealed)


def make_frame(
    *,
    cascade: int = 1,
    level: int = 0,
    kind: int = 1,
    group: int = 0,
    codec: int = 0,
    flags: int | None = None,
    n: int = 8,
    level_n: int | None = None,
    tile: tuple[int, int] = (0, 0),
    depth: int = 0,
    tick: int = 7200,
    epoch: int = EPOCH,
    payload: bytes | None = None,
    value: int | None = None,
) -> bytes:
    """A valid frame but for what is given; its counts run, or are all of one value."""
    channels = CHANNELS[group]
    samples = channels * n * n
    if payload is None:
        counts = [value if value is not None else (i * 7919) % 65536 - 32768 for i in range(samples)]
        payload = struct.pack(f"<{samples}h", *counts)
    there = [c < channels for c in range(3)]
    head = struct.pack(
        "<4sH6B5H2B3Q2I6f2I", b"SWF1", 88, cascade, level, kind, group, codec,
        (0 if depth else 1) if flags is None else flags, n, level_n or n, *tile, channels, depth, 0, tick, epoch, 3, 1,
        len(payload), *(0.002 * c for c in there), *(0.0 if codec == 4 else 0.001 * c for c in there), 0, 0,
    )  # fmt: skip
    return sealed(head + payload)


def patched(frame: bytes, at: int, value: bytes) -> bytes:
    """A frame with other bytes at an offset, and the checksum that fits."""
    return sealed(frame[:at] + value + frame[at + len(value) :])
