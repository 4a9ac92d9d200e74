"""The subscription of a client: what is wished, what of it was granted, and which frames are of it."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from typing import Final

from .errors import SwellcastError
from .header import Header
from .messages import Hello, Subscribed
from .request import Request
from .wish import Wish

_LOG: Final = logging.getLogger("swellcast")


class Subscription:
    """Outlives connections: it is asked for again on each of them, and after each change of layout."""

    def __init__(self, ids: Iterator[int]) -> None:
        self.request: Request[Subscribed] = Request("subscribe", ids)
        self.granted: Subscribed | None = None
        self._wish: Wish | None = None
        self._levels: dict[tuple[int, str, str], int] = {}

    async def change(self, wish: Wish, send: Callable[[], None]) -> Subscribed:
        """Wishes for something else; gives what was granted. After a refusal what was wished before stands."""
        before: Wish | None = None

        def wish_and_send() -> None:
            nonlocal before
            before, self._wish = self._wish, wish
            send()

        try:
            return await self.request.ask(wish_and_send)
        except SwellcastError:
            self._wish = before
            raise

    def message(self, hello: Hello) -> str | None:
        """The text that asks for what is wished of this sea; None where nothing is."""
        if self._wish is None:
            return None
        units = self._wish.units(hello)
        for group in self._wish.groups:
            if not any(unit.group == group for unit in units):
                _LOG.warning("scene %s gives nothing of %s", hello.scene, group)
        return self._wish.message(self.request.number(), hello, units)

    def take(self, message: Subscribed) -> set[tuple[int, str]]:
        """Takes what was granted; gives its cascades and groups."""
        self.granted = message
        self._levels = {(unit.cascade, unit.group, unit.codec): unit.level for unit in message.units}
        self.request.answer(message.id, message)
        return {(cascade, group) for cascade, group, _ in self._levels}

    def lose(self) -> None:
        """The connection was lost: nothing is granted on the next."""
        self.granted = None
        self._levels = {}

    def fits(self, header: Header, hello: Hello) -> bool:
        """Whether a frame is of this subscription and sea. The server may send it coarser than granted."""
        unit = header.unit
        cascade = hello.cascade(unit.cascade)
        level = self._levels.get((unit.cascade, unit.group, unit.codec))
        if cascade is None or level is None or header.epoch != hello.epoch or not cascade.contains(header.tick):
            return False
        return level <= unit.level < cascade.levels and header.level_n == cascade.n >> unit.level
