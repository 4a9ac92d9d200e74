"""The shared clock: server time from four timestamps of each exchange (PROTOCOL.md sections 6 and 8).

All times are whole microseconds. An exchange bounds the offset between the clocks from both sides, whatever the network
did: it is at most t1 - t0 (the request took no negative time) and at least t2 - t3. Delay only ever loosens these
bounds, so the tight ones are the good samples: the line below every upper bound and the line above every lower bound
enclose the truth (Moon, Skelly & Towsley 1999), and their middle is right by as much as the quickest requests and the
quickest answers take equally long.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from .vocabulary import TICKS_PER_SECOND

#: Exchanges that are kept.
_SAMPLES: Final = 128
#: A jump of server time larger than this is followed at once.
_STEP_US: Final = 200_000.0
#: Share of passing time by which server time is bent towards the truth otherwise.
_SLEW: Final = 0.01
#: No two clocks differ more in rate: twice what a poor crystal is off.
_MAX_DRIFT: Final = 200e-6
#: What two clocks usually differ: a slope is trusted as far as its noise is below this.
_USUAL_DRIFT: Final = 50e-6
#: Noise of a slope, times the span of the samples, as a share of half the least round trip.
_SLOPE_NOISE: Final = 0.1
#: Times beyond this are nobody's: 36,000 years.
_MOST_US: Final = 2**60

_Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Exchange:
    """One exchange of `time`: t0 and t3 by our clock, t1 and t2 by the server's."""

    t0: int
    t1: int
    t2: int
    t3: int

    def is_possible(self) -> bool:
        """Whether these four can be times of one exchange."""
        within = all(abs(t) <= _MOST_US for t in (self.t0, self.t1, self.t2, self.t3))
        return within and self.t3 >= self.t0 and self.t2 >= self.t1 and self.t2 - self.t1 <= self.t3 - self.t0


@dataclass(frozen=True, slots=True)
class _Fit:
    """Server time as a line over ours, relative to an origin."""

    offset: float
    drift: float
    #: Half the room between the bounds; below zero when no line passes between them.
    half_width: float
    bound: float


def monotonic_us() -> int:
    """Our time, microseconds."""
    return time.monotonic_ns() // 1000


class Clock:
    """Server time by our clock."""

    def __init__(self, now_us: Callable[[], int] = monotonic_us) -> None:
        self._now_us = now_us
        self.reset()

    def reset(self) -> None:
        """Forgets everything: another timeline begins."""
        self._exchanges: deque[Exchange] = deque()
        # Our time and the offset at the last fit; everything else is relative to them, so that floats stay exact.
        self._origin = (0, 0)
        self._fit: _Fit | None = None
        self._lag = 0.0  # what server time still lacks to the fit at the origin
        self._contradictions = 0  # exchanges in a row that the fit says can't be

    @property
    def synced(self) -> bool:
        """Whether there is any time to tell."""
        return self._fit is not None

    @property
    def drift(self) -> float:
        """By how much the server's clock runs faster than ours, as a share."""
        return self._fit.drift if self._fit else 0.0

    def now(self) -> float:
        """Server time now, seconds since tick 0; NaN before the first exchange."""
        us = self.server_us()
        return math.nan if us is None else us / 1e6

    def tick(self) -> float:
        """Server time now in ticks; NaN before the first exchange."""
        return self.now() * TICKS_PER_SECOND

    def server_us(self, own_us: int | None = None) -> int | None:
        """Server time in microseconds since tick 0, now or at a time of ours; None before the first exchange."""
        if self._fit is None:
            return None
        ours, offset = self._origin
        passed = self._at(own_us) - ours
        lag = math.copysign(max(0.0, abs(self._lag) - _SLEW * max(0, passed)), self._lag)
        return ours + passed + offset + _rounded(self._fit.offset + self._fit.drift * passed + lag)

    def error_bound_us(self, own_us: int | None = None) -> int | None:
        """How far server time can be off, even if one direction took no time; None before the first exchange."""
        if self._fit is None:
            return None
        passed = max(0, self._at(own_us) - self._origin[0])
        return math.ceil(self._fit.bound + max(0.0, abs(self._lag) - _SLEW * passed) + _MAX_DRIFT * passed)

    def observe(self, exchange: Exchange) -> bool:
        """Takes one exchange; says whether it was possible. An impossible one changes nothing."""
        if not exchange.is_possible():
            return False
        before = self.server_us(exchange.t3)
        if self._contradicts(exchange):
            # One of the clocks was set or stood still: the old samples say nothing about the new time. Two in a row, so
            # that one wild answer doesn't throw away a good fit.
            self._contradictions += 1
            if self._contradictions < 2:
                return True
            self._exchanges.clear()
        self._contradictions = 0
        if len(self._exchanges) == _SAMPLES:
            self._exchanges.popleft()
        self._exchanges.append(exchange)
        self._origin = (exchange.t3, exchange.t2 - exchange.t3)
        fit = _fit_of(self._exchanges, self._origin)
        while fit.half_width < 0 and len(self._exchanges) > 1:
            # Bounds that exclude one another: the clocks ran apart, or one was moved a little. The newer ones are right.
            self._exchanges.popleft()
            fit = _fit_of(self._exchanges, self._origin)
        self._fit = fit
        lag = 0.0 if before is None else float(before - exchange.t2 - _rounded(fit.offset))
        self._lag = 0.0 if abs(lag) > _STEP_US else lag
        return True

    def _at(self, own_us: int | None) -> int:
        return self._now_us() if own_us is None else own_us

    def _contradicts(self, exchange: Exchange) -> bool:
        """Whether an exchange rules out the fit by more than a step."""
        if self._fit is None:
            return False
        ours, offset = self._origin

        def at(t: int) -> float:
            assert self._fit is not None
            return offset + self._fit.offset + self._fit.drift * (t - ours)

        above = at(exchange.t0) > exchange.t1 - exchange.t0 + _STEP_US
        return above or at(exchange.t3) < exchange.t2 - exchange.t3 - _STEP_US


def _fit_of(exchanges: deque[Exchange], origin: tuple[int, int]) -> _Fit:
    """The middle between the line below all upper bounds and the line above all lower bounds."""
    ours, offset = origin
    upper = [(float(e.t0 - ours), float(e.t1 - e.t0 - offset)) for e in exchanges]
    lower = [(float(e.t3 - ours), float(e.t2 - e.t3 - offset)) for e in exchanges]
    span = upper[-1][0] - upper[0][0]
    steepest = (_supporting_slope(upper) - _supporting_slope([(x, -y) for x, y in lower])) / 2

    def within(drift: float) -> tuple[float, float]:
        above = min(y - drift * x for x, y in upper)
        below = max(y - drift * x for x, y in lower)
        return (above + below) / 2, (above - below) / 2

    # Jitter tilts the lines, the more the shorter they are: weigh the slope by what it is worth.
    noise = _SLOPE_NOISE * max(0.0, within(steepest)[1]) / max(1.0, span)
    drift = min(_MAX_DRIFT, max(-_MAX_DRIFT, steepest / (1 + (noise / _USUAL_DRIFT) ** 2)))
    middle, half_width = within(drift)
    # How far the middle can be off at the origin, whatever the clocks' rates.
    above = min(y + _MAX_DRIFT * abs(x) for x, y in upper)
    below = max(y - _MAX_DRIFT * abs(x) for x, y in lower)
    return _Fit(middle, drift, half_width, max(0.0, above - middle, middle - below))


def _supporting_slope(points: list[_Point]) -> float:
    """Slope of the highest line below all points, measured at their mean: an edge of the lower convex hull."""
    hull: list[_Point] = []
    for point in sorted(points):
        while len(hull) >= 2 and _turn(hull[-2], hull[-1], point) <= 0:
            hull.pop()
        hull.append(point)
    mean = sum(x for x, _ in points) / len(points)
    for (x0, y0), (x1, y1) in zip(hull, hull[1:], strict=False):
        if x1 >= mean and x1 > x0:
            return (y1 - y0) / (x1 - x0)
    return 0.0


def _turn(a: _Point, b: _Point, c: _Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _rounded(x: float) -> int:
    """To the nearest whole number, halves away from 0."""
    return int(math.copysign(math.floor(abs(x) + 0.5), x))
