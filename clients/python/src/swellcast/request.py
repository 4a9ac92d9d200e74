"""A request over the stream and its answer; one at a time, and it may be sent again on another connection."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from typing import Final, Generic, TypeVar

from .errors import Refused, SwellcastError
from .messages import ServerError

A = TypeVar("A")

#: How long an answer may take.
_PATIENCE_S: Final = 10.0


class Request(Generic[A]):
    """Requests of one kind; `ids` are shared with those of other kinds, so that a refusal is of one alone."""

    def __init__(self, what: str, ids: Iterator[int]) -> None:
        self._what = what
        self._ids = ids
        self._future: asyncio.Future[A] | None = None
        self._one_at_a_time = asyncio.Lock()
        #: Of what was asked last.
        self.id = 0

    def number(self) -> int:
        """The id for a message that is about to be sent."""
        self.id = next(self._ids)
        return self.id

    @property
    def waits(self) -> bool:
        """Whether somebody waits for an answer."""
        return self._future is not None and not self._future.done()

    async def ask(self, send: Callable[[], None]) -> A:
        """Sends, and waits for the answer; raises Refused."""
        async with self._one_at_a_time:
            self._future = asyncio.get_running_loop().create_future()
            try:
                send()
                async with asyncio.timeout(_PATIENCE_S):
                    return await self._future
            except TimeoutError:
                raise SwellcastError(f"{self._what} was not answered for {_PATIENCE_S:.0f} s") from None
            finally:
                self._future = None

    def answer(self, id: int, answer: A) -> None:
        """Takes an answer; one to an earlier message is nobody's."""
        if id == self.id and self._future is not None and not self._future.done():
            self._future.set_result(answer)

    def refuse(self, error: ServerError) -> bool:
        """Whether somebody waited for what is refused."""
        if error.id != self.id or self._future is None or self._future.done():
            return False
        self._future.set_exception(Refused(error.code, error.detail, error.field))
        return True
