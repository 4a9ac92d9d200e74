"""Keeps a link to a server open: connects, and when the connection is lost connects again, ever less often."""

from __future__ import annotations

import asyncio
import random
import time
from concurrent.futures import Executor
from typing import Final, Protocol

from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus, WebSocketException
from websockets.typing import Subprotocol

from .address import Address
from .clock import Clock
from .errors import ConnectError, ProtocolError
from .header import LONGEST_FRAME
from .link import Link, Listener
from .vocabulary import SUBPROTOCOL

#: Seconds between attempts; the last of them from then on. Each is taken a quarter shorter to a quarter longer, so that
#: clients that were lost together don't come back together.
_BACKOFF_S: Final = (0.25, 0.5, 1.0, 2.0, 3.0)
#: A connection that lasted so long was good: the attempt after it is a first again.
_GOOD_S: Final = 3.0
#: Longest wait that a server is believed to ask for.
_MOST_RETRY_AFTER_S: Final = 60.0
#: How long connecting and closing may take.
_PATIENCE_S: Final = 5.0
_GOODBYE_S: Final = 1.0


class Called(Listener, Protocol):
    """Who is told what comes, and when nothing does."""

    #: Whether a server has ever said what sea it has.
    @property
    def greeted(self) -> bool: ...

    def lost(self, reason: str, again_in_s: float) -> None:
        """There is no connection for so long at least."""


class Caller:
    """Bounded: one connection at a time."""

    def __init__(self, address: Address, clock: Clock, called: Called, threads: Executor, reports: bool) -> None:
        self._address = address
        self._clock = clock
        self._called = called
        self._threads = threads
        self._reports = reports
        self._failed = 0
        #: The connection, while there is one.
        self.link: Link | None = None

    async def call(self) -> None:
        """Runs for ever; raises ConnectError when there was no server of this protocol from the beginning."""
        while True:
            reason, at_least_s = await self._once()
            if not self._called.greeted:
                raise ConnectError(f"no stream at {self._address.stream}: {reason}")
            usual = _BACKOFF_S[min(self._failed, len(_BACKOFF_S) - 1)] * random.uniform(0.75, 1.25)
            self._failed += 1
            wait = max(usual, at_least_s)
            self._called.lost(reason, wait)
            await asyncio.sleep(wait)

    async def _once(self) -> tuple[str, float]:
        """Connects, and works until the connection is lost. Gives why, and how long the server asks to wait."""
        try:
            async with connect(
                self._address.stream,
                subprotocols=[Subprotocol(SUBPROTOCOL)],
                compression=None,
                open_timeout=_PATIENCE_S,
                close_timeout=_GOODBYE_S,
                ping_interval=None,  # status comes every second
                max_size=LONGEST_FRAME,
            ) as socket:
                if socket.subprotocol != SUBPROTOCOL:
                    raise ProtocolError(f"subprotocol is {socket.subprotocol}, must be {SUBPROTOCOL}")
                self.link = Link(socket, self._clock, self._called, self._threads, self._reports)
                began = time.monotonic()
                try:
                    reason = await self.link.run()
                except asyncio.CancelledError:
                    await socket.close()  # politely: it is the program that has enough
                    raise
                if time.monotonic() - began > _GOOD_S:
                    self._failed = 0
                return reason, 0.0
        except InvalidStatus as error:
            return f"refused with {error.response.status_code}", _retry_after(error)
        except TimeoutError:
            return f"no answer for {_PATIENCE_S:.0f} s", 0.0
        except (OSError, WebSocketException, ProtocolError) as error:
            return str(error) or type(error).__name__, 0.0
        finally:
            self.link = None


def _retry_after(error: InvalidStatus) -> float:
    text = error.response.headers.get("Retry-After", "")
    return min(float(text), _MOST_RETRY_AFTER_S) if text.isascii() and text.isdigit() and len(text) < 9 else 0.0
