"""The points that a client follows: what is asked for, and which messages are of it."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import SwellcastError
from .messages import Hello, PointsSubscribed
from .points import PointsFrame
from .request import Request

#: Farthest from the origin that a point may lie, metres.
_FARTHEST_M: Final = 1e9


def checked_points(points: ArrayLike) -> NDArray[np.float64]:
    """World positions [point][x, z] in metres, or ValueError."""
    array = np.asarray(points, np.float64)
    if array.size == 0:
        return np.empty((0, 2))
    if array.ndim != 2 or array.shape[1] != 2:
        raise ValueError(f"points are of shape {array.shape}, must be [point][x, z]")
    if not (np.abs(array) <= _FARTHEST_M).all():
        raise ValueError(f"points must be within {_FARTHEST_M:g} m of the origin")
    return array


class Following:
    """Outlives connections, as the subscription does."""

    def __init__(self, ids: Iterator[int]) -> None:
        self.request: Request[PointsSubscribed] = Request("points", ids)
        self._points: list[list[float]] = []
        self._rate_hz = 0

    async def change(self, points: NDArray[np.float64], rate_hz: int, send: Callable[[], None]) -> PointsSubscribed:
        """Follows other points. After a refusal those before stand."""
        before: tuple[list[list[float]], int] = ([], 0)

        def wish_and_send() -> None:
            nonlocal before
            before = self._points, self._rate_hz
            self._points, self._rate_hz = points.tolist(), rate_hz
            send()

        try:
            return await self.request.ask(wish_and_send)
        except SwellcastError:
            self._points, self._rate_hz = before
            raise

    def message(self, hello: Hello) -> str | None:
        """The text that asks for the points; None where nobody wants any."""
        if not self._points and not self.request.waits:
            return None
        rate_hz = self._rate_hz if self._rate_hz in hello.rates_hz else min(hello.rates_hz)
        told = {"type": "points", "id": self.request.number(), "rate_hz": rate_hz, "points": self._points}
        return json.dumps(told)

    def fits(self, points: PointsFrame, hello: Hello) -> bool:
        """Whether a message is of these points and this sea."""
        return points.id == self.request.id and points.epoch == hello.epoch and len(points.height) == len(self._points)
