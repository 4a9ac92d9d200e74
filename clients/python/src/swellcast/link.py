"""One WebSocket to a server: reads and decodes, exchanges time, reports how it fares, and notices when it is dead.

Who reads never waits for who decodes, up to a bounded number of messages: so that times of exchanges are right. Frames
are decoded in a thread of their own, one after the other in the order in which they came.
"""

from __future__ import annotations

import asyncio
import json
import time
from collections import deque
from concurrent.futures import Executor
from typing import Final, Protocol

from websockets.asyncio.client import ClientConnection
from websockets.exceptions import ConnectionClosed

from .clock import Clock, Exchange, monotonic_us
from .decode import Decoder, Tile
from .errors import FrameError, MessageError, MissingError, PayloadError, ProtocolError
from .fares import Fares
from .messages import Hello, ServerMessage, Subscribed, TimeAnswer
from .parse import parse_server_message
from .points import POINTS_MAGIC, PointsFrame, read_points
from .vocabulary import MOST_SAMPLES, Unit

#: Status comes once a second: longer silence is a dead connection.
_SILENCE_S: Final = 8.0
#: How long the server may take to read what is sent to it.
_PATIENCE_S: Final = 5.0
#: Exchanges that come every tenth of a second; then one comes every second.
_QUICK_EXCHANGES: Final = 20
#: Exchanges whose answers are still awaited.
_MOST_ASKED: Final = 16
#: Messages that wait for being decoded; the longest are 0.8 MB.
_MOST_PENDING: Final = 64
#: Messages that wait for being sent.
_MOST_UNSENT: Final = 64
#: A new beginning is asked for once in so many seconds at most.
_ANEW_S: Final = 1.0


class Listener(Protocol):
    """Who is told what comes. `subscribed` and `came` are in order with one another."""

    def heard(self, message: ServerMessage) -> None:
        """A text message that is not of the link's own concern."""

    def subscribed(self, message: Subscribed) -> None:
        """The answer to a subscription: frames after it are of that one."""

    def came(self, tile: Tile) -> None:
        """A frame of any sea."""

    def points_came(self, points: PointsFrame) -> None:
        """A message of points of any sea."""

    def dropped(self, why: str) -> None:
        """A message that could not be read."""


class Link:
    """A connection that is open."""

    def __init__(
        self, socket: ClientConnection, clock: Clock, listener: Listener, threads: Executor, reports: bool
    ) -> None:
        self._socket = socket
        self._clock = clock
        self._listener = listener
        self._threads = threads
        self._reports = reports
        self._decoder = Decoder(MOST_SAMPLES)
        self._fares = Fares()
        self._pending: asyncio.Queue[bytes | Subscribed] = asyncio.Queue(_MOST_PENDING)
        self._unsent: asyncio.Queue[str] = asyncio.Queue(_MOST_UNSENT)
        self._asked: deque[int] = deque(maxlen=_MOST_ASKED)
        #: Whether the server has said what sea it has.
        self.greeted = False
        self._heard_s = time.monotonic()
        self._asked_anew_s = -_ANEW_S

    async def run(self) -> str:
        """Works until the connection is lost, and says why; raises ProtocolError for one that isn't ours."""
        tasks = [asyncio.create_task(work) for work in (self._read(), self._decode(), self._write(), self._beat())]
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
        return done.pop().result()

    def post(self, text: str) -> None:
        """Sends a message as soon as the connection takes it."""
        try:
            self._unsent.put_nowait(text)
        except asyncio.QueueFull:
            # The server reads nothing: the writer finds out by itself.
            pass

    async def _read(self) -> str:
        try:
            while True:
                message = await self._socket.recv()
                at_us = monotonic_us()
                self._heard_s = time.monotonic()
                if isinstance(message, str):
                    await self._text(message, at_us)
                elif self.greeted:
                    await self._pending.put(message)
        except ConnectionClosed as closed:
            close = closed.rcvd
            return f"the server closed with {close.code}: {close.reason}" if close else "the connection broke"

    async def _text(self, text: str, at_us: int) -> None:
        try:
            message = parse_server_message(text)
        except MessageError as error:
            if not self.greeted:
                raise ProtocolError(f"the server's first message: {error}") from None
            self._listener.dropped(str(error))
            return
        if isinstance(message, TimeAnswer):
            self._answered(message, at_us)
        elif isinstance(message, Subscribed):
            await self._pending.put(message)
        elif message is not None:
            self.greeted = self.greeted or isinstance(message, Hello)
            self._listener.heard(message)

    def _answered(self, answer: TimeAnswer, at_us: int) -> None:
        t0 = int(answer.t0)
        if t0 == answer.t0 and t0 in self._asked:
            self._asked.remove(t0)
            self._clock.observe(Exchange(t0, answer.t1_us, answer.t2_us, at_us))

    async def _decode(self) -> str:
        loop = asyncio.get_running_loop()
        while True:
            message = await self._pending.get()
            if isinstance(message, Subscribed):
                self._begin(message)
                continue
            began = time.perf_counter()
            try:
                if message[:4] == POINTS_MAGIC:
                    self._listener.points_came(read_points(message))
                    continue
                tile = await loop.run_in_executor(self._threads, self._decoder.decode, message)
            except FrameError as error:
                self._refused(error)
                continue
            self._fares.decoded(tile.header.tick, (time.perf_counter() - began) * 1e3)
            self._listener.came(tile)

    def _begin(self, message: Subscribed) -> None:
        """What was granted is all that goes on, and all of it at full quality."""
        granted = {Unit(unit.cascade, unit.level, unit.error, unit.group, unit.codec) for unit in message.units}
        self._decoder.retain(lambda unit: unit in granted)
        self._fares.reset()
        self._listener.subscribed(message)

    def _refused(self, error: FrameError) -> None:
        """A frame that can't be read may leave others unread: all begins anew, unless that was asked for just now."""
        now = time.monotonic()
        waits = now - self._asked_anew_s < _ANEW_S
        if isinstance(error, MissingError | PayloadError) and not waits:
            self._asked_anew_s = now
            self._report(lost=True)
        # What was under way when a new beginning was asked for is no fault.
        if not (isinstance(error, MissingError) and waits):
            self._listener.dropped(str(error))

    async def _write(self) -> str:
        try:
            while True:
                text = await self._unsent.get()
                async with asyncio.timeout(_PATIENCE_S):
                    await self._socket.send(text)
        except ConnectionClosed:
            return await self._forever()  # the reader says why
        except TimeoutError:
            return "the server reads nothing"

    async def _beat(self) -> str:
        exchanges = 0
        reported = time.monotonic()
        while True:
            if time.monotonic() - self._heard_s > _SILENCE_S:
                return f"the server is silent for {_SILENCE_S:.0f} s"
            if self.greeted:
                t0 = monotonic_us()
                self._asked.append(t0)
                self.post(json.dumps({"type": "time", "t0": t0}))
                exchanges += 1
            if self._reports and time.monotonic() - reported > 0.95 and self._fares.newest > 0 and self._clock.synced:
                reported = time.monotonic()
                self._report(lost=False)
            await asyncio.sleep(0.1 if exchanges < _QUICK_EXCHANGES else 1.0)

    def _report(self, lost: bool) -> None:
        self.post(self._fares.report(self._clock.server_us(), lost))

    @staticmethod
    async def _forever() -> str:
        await asyncio.Event().wait()
        raise AssertionError("nobody sets it")
