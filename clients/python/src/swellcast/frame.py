"""A frame as a program sees it: all channels of one unit at one tick, over a whole patch."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .header import FLAG_KEY, FLAG_SATURATED, Header
from .vocabulary import GROUPS, TICKS_PER_SECOND, Unit


@dataclass(frozen=True, eq=False)
class Frame:
    """One unit at one tick. Arrays are [channel][z][x]; a sample lies at x = ix * patch_m / n, z = iz * patch_m / n."""

    unit: Unit
    tick: int
    epoch: int
    #: Newest entry of the control log that is in effect at this tick.
    sequence: int
    #: How many changes of layout are in effect at this tick.
    layout: int
    key: bool
    #: Some sample was clamped, so that `max_error` does not hold for it.
    saturated: bool
    #: Value of a count, and guaranteed largest error, of each channel.
    step: tuple[float, ...]
    max_error: tuple[float, ...]
    #: What was sent: signed 16-bit counts, or None with the codecs of floats.
    counts: NDArray[np.int16] | None
    floats: NDArray[np.float32] | None

    @staticmethod
    def of(header: Header, counts: NDArray[np.int16] | None, floats: NDArray[np.float32] | None) -> Frame:
        """The frame that a header describes, over arrays of the whole patch."""
        return Frame(
            header.unit,
            header.tick,
            header.epoch,
            header.sequence,
            header.layout,
            header.flags & FLAG_KEY != 0,
            header.flags & FLAG_SATURATED != 0,
            header.step,
            header.max_error,
            counts,
            floats,
        )

    @property
    def data(self) -> NDArray[np.int16] | NDArray[np.float32]:
        """What was sent: counts, or floats."""
        if self.counts is not None:
            return self.counts
        assert self.floats is not None
        return self.floats

    @property
    def n(self) -> int:
        """Samples a side."""
        return int(self.data.shape[-1])

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels, in order."""
        return GROUPS[self.unit.group]

    @property
    def time_s(self) -> float:
        """Seconds since the sea began."""
        return self.tick / TICKS_PER_SECOND

    @cached_property
    def planes(self) -> NDArray[np.float32]:
        """Values, in the units of PROTOCOL.md section 5."""
        return self.values(1.0)

    def values(self, weight: float) -> NDArray[np.float32]:
        """Values times a weight."""
        if self.counts is None:
            assert self.floats is not None
            return self.floats * np.float32(weight)
        factors = np.asarray(self.step, np.float32) * np.float32(weight)
        return self.counts.astype(np.float32) * factors[:, None, None]

    def __getitem__(self, channel: str) -> NDArray[np.float32]:
        """The plane of a channel by its name."""
        if channel not in self.channels:
            raise KeyError(f"channel is {channel!r}, must be one of {', '.join(self.channels)}")
        plane: NDArray[np.float32] = self.planes[self.channels.index(channel)]
        return plane
