"""Frames back to counts (PROTOCOL.md sections 5 and 10), in the order in which they came.

Invariant: a frame that is wrong in any way is refused as a whole, and what was decoded before stands.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .errors import MissingError, PayloadError
from .header import HEADER_BYTES, Header, read_header
from .history import Counts, History
from .inflate import inflated, restore_plane
from .predict import Taps
from .rans import read_plane
from .vocabulary import FLOATS, PREDICTING, Unit, layer_of

_TAPS: Final = struct.Struct("<8hI")


@dataclass(frozen=True, slots=True)
class Tile:
    """One tile of one unit at one tick: its counts, or floats with the codecs that have none; [channel][z][x]."""

    header: Header
    counts: Counts | None
    floats: NDArray[np.float32] | None


@dataclass(slots=True)
class _Held:
    history: History
    samples: int
    epoch: int


class Decoder:
    """Bounded: what is kept for predictions is four frames of a tile, of no more samples in all than it is made for."""

    def __init__(self, most_samples: int) -> None:
        self._most_samples = most_samples
        self._held: dict[tuple[Unit, int, int], _Held] = {}

    def retain(self, wanted: Callable[[Unit], bool]) -> None:
        """Forgets the frames of units that are not wanted any more."""
        self._held = {key: held for key, held in self._held.items() if wanted(key[0])}

    def decode(self, frame: bytes) -> Tile:
        """Reads one whole binary message; raises FrameError."""
        header = read_header(frame)
        codec, shape = header.unit.codec, (header.channels, header.n, header.n)
        if codec in FLOATS:
            kind = "<f2" if codec == "f16" else "<f4"
            floats = np.frombuffer(frame, kind, header.samples, HEADER_BYTES).astype(np.float32)
            if not np.isfinite(floats).all():
                raise PayloadError("payload: a value that is not finite")
            return Tile(header, None, floats.reshape(shape))
        if codec not in PREDICTING:
            counts = np.frombuffer(frame, "<i2", header.samples, HEADER_BYTES).astype(np.int16, copy=False)
            return Tile(header, counts.reshape(shape), None)
        counts = self._predicted(header, frame)
        # What the program gets is what later frames are predicted from.
        counts.flags.writeable = False
        if layer_of(header.tick) < 2:
            self._keep(header, counts)
        return Tile(header, counts, None)

    def _predicted(self, header: Header, frame: bytes) -> Counts:
        basis: list[Counts] = []
        if header.depth > 0:
            held = self._held.get(_key(header))
            found = held.history.basis(header.tick, header.depth) if held and _fits(held, header) else None
            if found is None:
                raise MissingError(f"predicted from a frame that is not held: depth {header.depth} at tick {header.tick}")
            basis = found
        if header.unit.codec == "rans":
            return _read_rans(header, frame, basis)
        return _read_deflate(header, frame, basis)

    def _keep(self, header: Header, counts: Counts) -> None:
        key = _key(header)
        held = self._held.get(key)
        if held is None or not _fits(held, header):
            self._held.pop(key, None)
            # More than was asked for: what comes of it can't be predicted from.
            if sum(other.samples for other in self._held.values()) + header.samples > self._most_samples:
                return
            held = self._held[key] = _Held(History(), header.samples, header.epoch)
        held.history.keep(header.tick, counts)


def _key(header: Header) -> tuple[Unit, int, int]:
    return header.unit, header.tile_x, header.tile_z


def _fits(held: _Held, header: Header) -> bool:
    """Whether it is of the same sea and size."""
    return held.samples == header.samples and held.epoch == header.epoch


def _read_rans(header: Header, frame: bytes, basis: list[Counts]) -> Counts:
    counts = np.empty((header.channels, header.n, header.n), np.int16)
    at = HEADER_BYTES
    for channel in range(header.channels):
        taps, wide = _read_taps(frame, at)
        if wide:
            raise PayloadError("payload: wide is 1, must be 0 with rans")
        planes = [frame_before[channel] for frame_before in basis]
        counts[channel], at = read_plane(frame, at + _TAPS.size, header.depth, planes, taps, header.n)
    if at != len(frame):
        raise PayloadError("payload: bytes after the last plane")
    return counts


def _read_deflate(header: Header, frame: bytes, basis: list[Counts]) -> Counts:
    heads = [_read_taps(frame, HEADER_BYTES + channel * _TAPS.size) for channel in range(header.channels)]
    if header.depth == 0 and any(any(taps) for taps, _ in heads):
        raise PayloadError("payload: taps where they are fixed")
    samples = header.n * header.n
    size = samples * (header.channels + sum(wide for _, wide in heads))
    stream = frame[HEADER_BYTES + header.channels * _TAPS.size :]
    residuals = np.frombuffer(inflated(stream, size), np.uint8)
    counts = np.empty((header.channels, header.n, header.n), np.int16)
    at = 0
    for channel, (taps, wide) in enumerate(heads):
        low = residuals[at : at + samples]
        high = residuals[at + samples : at + 2 * samples] if wide else None
        planes = [frame_before[channel] for frame_before in basis]
        counts[channel] = restore_plane(low, high, header.depth, planes, taps, header.n)
        at += samples * (1 + wide)
    return counts


def _read_taps(frame: bytes, at: int) -> tuple[Taps, bool]:
    """The taps of a plane, and whether its residuals have two bytes."""
    if len(frame) - at < _TAPS.size:
        raise PayloadError("payload: too short")
    *taps, wide = _TAPS.unpack_from(frame, at)
    if wide > 1:
        raise PayloadError(f"payload: wide and the bytes after it are {wide:#x}, must be 0 or 1")
    return tuple(taps), wide == 1
