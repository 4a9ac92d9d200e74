"""The client: connects, subscribes, gives frames, and comes back by itself when the connection is lost."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from types import TracebackType
from typing import Any, Final, Self

from numpy.typing import ArrayLike

from . import http
from .address import Address
from .caller import Caller
from .clock import Clock
from .errors import SwellcastError
from .events import Event
from .following import checked_points
from .frame import Frame
from .lane import Lane
from .messages import Hello, PointsSubscribed, Quality, Status, Subscribed
from .playback import Playback
from .points import PointsFrame
from .sea import Sea
from .wish import Wish

#: NumPy reads it in time, and it is a fifth of the bytes of plain counts: see the README.
DEFAULT_CODEC: Final = "deflate"


def connect(url: str, *, playback: bool = True, reports: bool = True) -> Ocean:
    """A client of the server at a URL like http://host:port; use it as `async with connect(url) as ocean:`.

    `playback` keeps recent frames for `ocean.playback`. `reports` tells the server how this client fares, so that it sends
    less to one that falls behind; without, it finds out later, when what it sends is not taken.
    """
    return Ocean(url, playback=playback, reports=reports)


class Ocean:
    """One sea, as long as the program wants it: connections come and go, the subscription stays."""

    def __init__(self, url: str, *, playback: bool = True, reports: bool = True) -> None:
        address = Address.of(url)
        #: Server time by our clock.
        self.clock = Clock()
        self._threads = ThreadPoolExecutor(1, "swellcast-decode")
        self._sea = Sea(self.clock, self._post, playback)
        self._caller = Caller(address, self.clock, self._sea, self._threads, reports)
        self._http = address.http
        self._task: asyncio.Task[None] | None = None

    async def __aenter__(self) -> Self:
        """Connects; raises ConnectError when there is no such server. Later it comes back by itself."""
        events = self._sea.events()
        self._task = asyncio.create_task(self._work())
        try:
            while not self._sea.greeted:
                await events.get()
        except BaseException:
            await self.close()
            raise
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.close()

    async def close(self) -> None:
        """Ends the connection, and all iterations."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
        self._threads.shutdown(wait=False, cancel_futures=True)
        self._sea.end(None)

    @property
    def hello(self) -> Hello:
        """What sea this is; the newest."""
        if self._sea.hello is None:
            raise SwellcastError("not connected yet: use `async with connect(url) as ocean`")
        return self._sea.hello

    @property
    def status(self) -> Status | None:
        """How the sea and the server are; the newest, None before the first."""
        return self._sea.status

    @property
    def quality(self) -> Quality | None:
        """What less is sent than was granted; None where all of it is."""
        return self._sea.quality

    @property
    def granted(self) -> Subscribed | None:
        """What is sent; None while nothing is."""
        return self._sea.subscription.granted

    @property
    def playback(self) -> Playback:
        """The water between frames."""
        return self._sea.playback

    @property
    def connected(self) -> bool:
        """Whether there is a connection now."""
        return self._caller.link is not None

    @property
    def dropped(self) -> int:
        """Frames that the program did not take in time, or that lacked tiles."""
        return self._sea.frames.dropped + self._sea.patches.incomplete

    @property
    def stray(self) -> int:
        """Frames of another sea or subscription, which were ignored."""
        return self._sea.stray

    async def subscribe(
        self,
        groups: Iterable[str] = ("displacement",),
        cascades: Iterable[int] | None = None,
        level: int = 0,
        rate_hz: int | None = None,
        error: str = "1mm",
        codec: str = DEFAULT_CODEC,
        *,
        keys: bool = False,
    ) -> Subscribed:
        """Asks for frames, in place of all that was asked for before; gives what was granted.

        `cascades` are places in the layout, 0 for the longest waves, None for all; `level` 0 is the full grid, and a
        cascade that has no such level gives its nearest; `rate_hz` None is the server's lowest; `error` is the name of
        an error class. Raises ValueError or Refused for what this sea doesn't have.
        """
        chosen = None if cascades is None else frozenset(cascades)
        names = (groups,) if isinstance(groups, str) else tuple(groups)
        wish = Wish(names, chosen, level, rate_hz, error, codec, keys)
        wish.check(self.hello)
        return await self._sea.subscription.change(wish, self._sea.send_subscription)

    async def follow(self, points: ArrayLike, rate_hz: int | None = None) -> PointsSubscribed:
        """Asks for the water at fixed points [point][x, z] of the world, metres, in place of those before.

        Messages come from `points()`; no points end them.
        """
        checked = checked_points(points)
        hello = self.hello
        if len(checked) > hello.limits.points:
            raise ValueError(f"points are {len(checked)}, must be at most {hello.limits.points}")
        rate = min(hello.rates_hz) if rate_hz is None else rate_hz
        if rate not in hello.rates_hz:
            raise ValueError(f"rate_hz is {rate}, must be one of {list(hello.rates_hz)}")
        return await self._sea.following.change(checked, rate, self._sea.send_points)

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> Frame:
        """The next frame, as they come: those of one tick together, those between others later than these."""
        return await self._sea.frames.get()

    def points(self) -> Lane[PointsFrame]:
        """Messages of the points that are followed: `async for points in ocean.points():`."""
        return self._sea.points

    def events(self) -> Lane[Event]:
        """What happens beside frames from now on: `async for event in ocean.events():`."""
        return self._sea.events()

    async def probe(
        self,
        points: ArrayLike,
        *,
        tick: int | None = None,
        fields: Iterable[str] | None = None,
        method: str | None = None,
        share: float | None = None,
    ) -> http.Probe:
        """The water at points [point][x, z] of the world, metres, now or at a tick (docs/probe.md)."""
        asked = checked_points(points)
        given = {"tick": tick, "fields": None if fields is None else list(fields), "method": method, "share": share}
        body = {"points": asked.tolist()} | {name: value for name, value in given.items() if value is not None}
        return http.probe(await self._ask("POST", "/probe", body), asked)

    async def set_wind(
        self,
        speed_mps: float,
        direction_from_deg: float,
        *,
        transition_s: float | None = None,
        in_seconds: float | None = None,
        effective_tick: int | None = None,
    ) -> http.Accepted:
        """Changes the wind for all clients: soon, or when it is said; the sea takes `transition_s` to follow."""
        body = {"speed_mps": speed_mps, "direction_from_deg": direction_from_deg}
        given = {"transition_s": transition_s, "in_seconds": in_seconds, "effective_tick": effective_tick}
        body |= {name: value for name, value in given.items() if value is not None}
        for name, value in body.items():
            if not math.isfinite(value):
                raise ValueError(f"{name} is {value}, must be finite")
        return http.accepted(await self._ask("PUT", "/wind", body))

    async def statistics(self) -> http.Statistics:
        """What the sea is like now, from the energies of its modes."""
        return http.statistics(await self._ask("GET", "/statistics"))

    async def scene(self) -> dict[str, Any]:
        """The scene, its layout, warnings and state, as the server tells them."""
        return await self._ask("GET")

    async def _ask(self, method: str, what: str = "", body: dict[str, Any] | None = None) -> dict[str, Any]:
        return await http.ask(self._http, method, http.path_of(self.hello.scene, what), body)

    async def _work(self) -> None:
        try:
            await self._caller.call()
        except asyncio.CancelledError:
            raise
        except Exception as error:
            self._sea.end(error)

    def _post(self, text: str) -> None:
        if self._caller.link is not None:
            self._caller.link.post(text)
