"""What a program can be told of beside frames: the sea changes, the server goes away and comes back."""

from __future__ import annotations

from dataclasses import dataclass

from .messages import Change, Hello, Quality, ServerError, Status


@dataclass(frozen=True, slots=True)
class EpochChanged:
    """Another sea begins: all that was held of the one before is forgotten."""

    before: int
    after: int


@dataclass(frozen=True, slots=True)
class Disconnected:
    """The connection was lost or could not be made again; the next attempt comes after so many seconds."""

    reason: str
    again_in_s: float


@dataclass(frozen=True, slots=True)
class Dropped:
    """A message that could not be read; what was read before stands."""

    why: str


#: A Hello is told for each connection, and before a change of layout.
Event = Hello | Change | Status | Quality | ServerError | EpochChanged | Disconnected | Dropped
