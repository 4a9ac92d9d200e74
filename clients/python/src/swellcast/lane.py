"""A bounded queue between the network and a program that may be slow: what is oldest is dropped, and counted."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import Generic, TypeVar

T = TypeVar("T")


class Lane(Generic[T]):
    """Holds at most so many things, and so much of them altogether; one thing is always let in."""

    def __init__(self, most: int, most_weight: int) -> None:
        self._most = most
        self._most_weight = most_weight
        self._held: deque[tuple[T, int]] = deque()
        self._weight = 0
        self._ended = False
        self._error: BaseException | None = None
        self._stirred = asyncio.Event()
        #: Things that nobody took in time.
        self.dropped = 0

    def put(self, thing: T, weight: int = 0) -> None:
        """Adds a thing; never waits."""
        self._held.append((thing, weight))
        self._weight += weight
        while len(self._held) > self._most or (self._weight > self._most_weight and len(self._held) > 1):
            self._weight -= self._held.popleft()[1]
            self.dropped += 1
        self._stirred.set()

    def clear(self) -> None:
        """Forgets what is held."""
        self._held.clear()
        self._weight = 0

    def end(self, error: BaseException | None = None) -> None:
        """Nothing more will come; `error` says why, where it is no good end."""
        self._ended = True
        self._error = self._error or error
        self._stirred.set()

    def __aiter__(self) -> Lane[T]:
        return self

    async def __anext__(self) -> T:
        return await self.get()

    async def get(self) -> T:
        """The oldest thing; raises the error that ended this, or StopAsyncIteration, when all are taken."""
        while not self._held:
            if self._error is not None:
                raise self._error
            if self._ended:
                raise StopAsyncIteration
            self._stirred.clear()
            await self._stirred.wait()
        thing, weight = self._held.popleft()
        self._weight -= weight
        return thing
