"""How a connection fares: what it tells the server about once a second, so that it is given what it can take."""

from __future__ import annotations

import json

from .vocabulary import TICKS_PER_SECOND


class Fares:
    """What decoding took of late, and how far what came reaches."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Begins anew: another subscription."""
        self.newest = 0  # tick of all that was decoded: of a cascade that has ended nothing comes
        self._last = -1
        self._ticks = 0  # since the last report: frames of how many ticks, and what they took
        self._ms = 0.0

    def decoded(self, tick: int, ms: float) -> None:
        """Counts a frame, and what decoding it took."""
        self.newest = max(self.newest, tick)
        # Frames of one tick stand together.
        self._ticks += tick != self._last
        self._last = tick
        self._ms += ms

    def report(self, server_us: int | None, lost: bool) -> str:
        """The text of a report at this server time."""
        ahead = 0.0 if server_us is None else (self.newest * 1e6 / TICKS_PER_SECOND - server_us) / 1e3
        decode_ms = self._ms / max(1, self._ticks)
        self._ticks, self._ms = 0, 0.0
        told = {"type": "report", "tick": self.newest, "decode_ms": decode_ms, "buffer_ms": ahead}
        return json.dumps(told | ({"lost": True} if lost else {}))
