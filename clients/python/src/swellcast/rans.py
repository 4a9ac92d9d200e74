"""Reads a coded plane (PROTOCOL.md section 10, codec 1): rANS of four states in turn.

Where a sample is read depends on all samples before it, so there is nothing here that NumPy could do side by side but
predictions and what becomes of the symbols. The loops are written for speed: each context stands in place of its
number as the list of its slots, and a slot holds all that reading it takes.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .errors import PayloadError
from .predict import Plane, Predicted, Taps, predict_above, predict_in_time

_HEAD: Final = struct.Struct("<2BH2I4I")
_SLOTS: Final = 1024
_CONTEXTS: Final = 4
_MOST_SHIFT: Final = 8
#: The least a state may be between two samples.
_LEAST: Final = 1 << 15

#: How many slots its symbol has, its place among them, and the symbol plus 128.
_Slot = tuple[int, int, int]
_Table = list[_Slot]


class _Coded:
    """The parts of a coded plane: its head is checked, its samples are not read yet."""

    def __init__(self, payload: bytes, at: int, samples: int) -> None:
        if len(payload) - at < _HEAD.size:
            raise PayloadError("payload: too short")
        contexts, self.shift, table_bytes, words, escapes, *states = _HEAD.unpack_from(payload, at)
        if contexts not in (1, _CONTEXTS):
            raise PayloadError(f"payload: contexts is {contexts}, must be 1 or {_CONTEXTS}")
        if self.shift > (_MOST_SHIFT if contexts == 1 else 0):
            raise PayloadError(f"payload: shift is {self.shift}, must be 0 to {_MOST_SHIFT}, and 0 with 4 contexts")
        if table_bytes % 2 == 1:
            raise PayloadError(f"payload: table_bytes is {table_bytes}, must be even")
        if words > 2 * samples or escapes > samples:
            raise PayloadError(f"payload: {words} words and {escapes} escapes, more than {samples} samples can take")
        if not all(_LEAST <= state < 1 << 31 for state in states):
            raise PayloadError(f"payload: states are {states}, must be 2^15 to 2^31 - 1")
        tables = at + _HEAD.size
        self.states: list[int] = states
        first_word, first_escape = tables + table_bytes, tables + table_bytes + 2 * words
        used = first_escape + 2 * escapes
        self.end = (used + 3) // 4 * 4
        if self.end > len(payload):
            raise PayloadError("payload: too short")
        if any(payload[used : self.end]):
            raise PayloadError("payload: padding is not zero")
        self.tables = _read_tables(payload[tables:first_word], contexts)
        words_read: list[int] = np.frombuffer(payload, "<u2", words, first_word).tolist()
        self.words = iter(words_read)
        self.escapes = np.frombuffer(payload, "<i2", escapes, first_escape)


def read_plane(
    payload: bytes, at: int, depth: int, planes: Sequence[Plane], taps: Taps, n: int
) -> tuple[NDArray[np.int16], int]:
    """Reads a plane of n x n counts; gives it, and where in the payload it ends. Raises PayloadError."""
    coded = _Coded(payload, at, n * n)
    try:
        if depth == 0:
            counts = _read_in_space(coded, taps, n)
        else:
            counts = _read_in_time(coded, predict_in_time(depth, planes, taps))
    except StopIteration:
        raise PayloadError("payload: fewer words or escapes than samples need") from None
    # An encoder begins with the least state, so that is where a whole plane ends.
    if next(coded.words, None) is not None or any(state != _LEAST for state in coded.states):
        raise PayloadError("payload: a plane does not end where it should")
    return counts, coded.end


def _read_in_time(coded: _Coded, predicted: Predicted) -> NDArray[np.int16]:
    if coded.shift > 0:
        symbols, low = _shifted_symbols(coded, predicted.size)
        residuals = (np.frombuffer(symbols, np.uint8).astype(np.int32) - 128 << coded.shift) + np.frombuffer(low, np.uint8)
    else:
        symbols = _symbols(coded, predicted)
        residuals = np.frombuffer(symbols, np.uint8).astype(np.int32) - 128
    # The lower 16 bits count.
    counts = ((predicted >> 12).ravel() + residuals).astype(np.int16)
    escaped = np.flatnonzero(np.frombuffer(symbols, np.uint8) == 0)
    if len(escaped) != len(coded.escapes):
        raise PayloadError(f"payload: {len(coded.escapes)} escapes, must be {len(escaped)}")
    counts[escaped] = coded.escapes
    plane: NDArray[np.int16] = counts.reshape(predicted.shape)
    return plane


def _symbols(coded: _Coded, predicted: Predicted) -> bytearray:
    """Each symbol plus 128, of a plane that is predicted as a whole."""
    # An array of objects, so that taking from it gives the lists themselves.
    tables = np.empty(_CONTEXTS, object)
    tables[:] = (coded.tables * _CONTEXTS)[:_CONTEXTS]
    contexts: Iterator[_Table] = iter(tables[(predicted.ravel() >> 10) & 3].tolist())
    word = coded.words.__next__
    symbols = bytearray()
    put = symbols.append
    x0, x1, x2, x3 = coded.states
    for t0, t1, t2, t3 in zip(contexts, contexts, contexts, contexts, strict=True):
        slots, place, symbol = t0[x0 & 1023]
        x0 = slots * (x0 >> 10) + place
        if x0 < 32768:
            x0 = x0 << 16 | word()
        put(symbol)
        slots, place, symbol = t1[x1 & 1023]
        x1 = slots * (x1 >> 10) + place
        if x1 < 32768:
            x1 = x1 << 16 | word()
        put(symbol)
        slots, place, symbol = t2[x2 & 1023]
        x2 = slots * (x2 >> 10) + place
        if x2 < 32768:
            x2 = x2 << 16 | word()
        put(symbol)
        slots, place, symbol = t3[x3 & 1023]
        x3 = slots * (x3 >> 10) + place
        if x3 < 32768:
            x3 = x3 << 16 | word()
        put(symbol)
    coded.states = [x0, x1, x2, x3]
    return symbols


def _shifted_symbols(coded: _Coded, samples: int) -> tuple[bytearray, bytearray]:
    """Each symbol plus 128 and the low bits beside it, of a plane with low bits; such a plane has one context."""
    table, states, word, shift = coded.tables[0], coded.states, coded.words.__next__, coded.shift
    mask = (1 << shift) - 1
    symbols, low = bytearray(), bytearray()
    for i in range(samples):
        x = states[i & 3]
        slots, place, symbol = table[x & 1023]
        x = slots * (x >> 10) + place
        if x < 32768:
            x = x << 16 | word()
        symbols.append(symbol)
        low.append(x & mask)
        x >>= shift
        if x < 32768:
            x = x << 16 | word()
        states[i & 3] = x
    return symbols, low


def _read_in_space(coded: _Coded, taps: Taps, n: int) -> NDArray[np.int16]:
    """A plane that is predicted from its own samples: each depends on the one before it."""
    counts = np.empty((n, n), np.int16)
    tables, word, shift = (coded.tables * _CONTEXTS)[:_CONTEXTS], coded.words.__next__, coded.shift
    x0, x1, x2, x3 = coded.states
    mask = (1 << shift) - 1
    escapes = iter(coded.escapes.tolist())
    # The two taps of the west sample as one, in units of 2^-16: shifted together they give what each gives by itself.
    # The first row follows the sample to its left.
    west_tap, far_tap = 1 << 16, 0
    for z in range(n):
        row: list[int] = []
        west = far = 0
        for above in predict_above(counts, taps, z):
            # The sum may be beyond 32 bits; only bits 10 to 27 are looked at, which are the same as of one that wraps.
            p = above + far_tap * far + (west_tap * west >> 4)
            slots, place, symbol = tables[p >> 10 & 3][x0 & 1023]
            x0 = slots * (x0 >> 10) + place
            if x0 < 32768:
                x0 = x0 << 16 | word()
            count = (p >> 12) + symbol - 128
            if shift > 0:
                count = (p >> 12) + (symbol - 128 << shift) + (x0 & mask)
                x0 >>= shift
                if x0 < 32768:
                    x0 = x0 << 16 | word()
            if symbol == 0:
                count = next(escapes)
            elif not -32768 <= count <= 32767:
                count = (count + 32768 & 65535) - 32768
            far = west if row else count
            west = count
            row.append(count)
            # The next sample is of the next state.
            x0, x1, x2, x3 = x1, x2, x3, x0
        counts[z] = row
        west_tap, far_tap = (taps[0] << 4) + taps[7], taps[4]
    coded.states = [x0, x1, x2, x3]
    if next(escapes, None) is not None:
        raise PayloadError("payload: more escapes than samples need")
    return counts


def _read_tables(tables: bytes, contexts: int) -> list[_Table]:
    left = iter(tables)
    try:
        read = [_read_table(left) for _ in range(contexts)]
    except StopIteration:
        raise PayloadError("payload: a table ends early") from None
    rest = list(left)
    if rest not in ([], [0]):
        raise PayloadError("payload: bytes after the tables")
    return read


def _read_table(left: Iterator[int]) -> _Table:
    first, more = next(left), next(left)
    if first + more > 255:
        raise PayloadError(f"payload: a table up to symbol {first + more - 128}, must be at most 127")
    table: list[list[_Slot]] = []
    total = 0
    for symbol in range(first, first + more + 1):
        slots = next(left)
        if slots >= 128:
            slots = slots & 127 | next(left) << 7
        total += slots
        if total > _SLOTS:
            break
        table.append([(slots, place, symbol) for place in range(slots)])
    if total != _SLOTS:
        raise PayloadError(f"payload: a table of {total} slots, must be {_SLOTS}")
    return list(chain.from_iterable(table))
