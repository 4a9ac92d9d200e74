"""What a program wants of the sea, and the units that this is of the sea that a `hello` describes."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from .messages import Cascade, Hello
from .vocabulary import CLASSES, CODECS, GROUP_NAMES, LAST_TICK, Unit


@dataclass(frozen=True, slots=True)
class Wish:
    """Said in words that outlive a layout: it is asked for again when the layout changes or the server restarts."""

    groups: tuple[str, ...]
    #: Places in the layout, 0 for the longest waves; None for all.
    cascades: frozenset[int] | None
    level: int
    rate_hz: int | None
    error: str
    codec: str
    keys: bool = False

    def __post_init__(self) -> None:
        for group in self.groups:
            _one_of("groups", group, GROUP_NAMES)
        _one_of("error", self.error, CLASSES)
        _one_of("codec", self.codec, CODECS)
        if not 0 <= self.level <= 255:
            raise ValueError(f"level is {self.level}, must be 0 to 255")
        if self.cascades is not None and any(not 0 <= place <= 255 for place in self.cascades):
            raise ValueError(f"cascades are {sorted(self.cascades)}, each must be 0 to 255, or None for all")

    def check(self, hello: Hello) -> None:
        """Refuses what this sea doesn't have, by name."""
        for group in self.groups:
            _one_of("groups", group, tuple(had.name for had in hello.groups))
        if self.rate_hz is not None and self.rate_hz not in hello.rates_hz:
            raise ValueError(f"rate_hz is {self.rate_hz}, must be one of {list(hello.rates_hz)}")
        places = set(hello.layout.ranks().values())
        if self.cascades is not None and not self.cascades <= places:
            raise ValueError(f"cascades are {sorted(self.cascades)}, each must be one of {sorted(places)}")

    def rate(self, hello: Hello) -> int:
        """The rate asked for, or the nearest that the server has."""
        if self.rate_hz is None:
            return min(hello.rates_hz)
        wanted = self.rate_hz
        return min(hello.rates_hz, key=lambda rate: abs(rate - wanted))

    def units(self, hello: Hello) -> list[Unit]:
        """Units of every group and cascade that are wanted and had, what was named first first.

        No more than fit into one subscription: while two layouts are there at once, that may be fewer than are wanted.
        """
        had = {group.name for group in hello.groups}
        ranks = hello.layout.ranks()
        units = []
        for group in self.groups:
            for cascade in hello.layout.cascades:
                if group in had and (self.cascades is None or ranks[cascade.index] in self.cascades):
                    level = self._level_of(cascade, group)
                    if level is not None:
                        units.append(Unit(cascade.index, level, self.error, group, self.codec))
        del units[hello.limits.units :]
        while units and len(self.message(LAST_TICK, hello, units)) > hello.limits.message_bytes:
            units.pop()
        return units

    def message(self, id: int, hello: Hello, units: Sequence[Unit]) -> str:
        """The text of a subscription to these units."""
        keys = {"keys": True} if self.keys else {}
        told = [_told(unit) for unit in units]
        return json.dumps({"type": "subscribe", "id": id, "rate_hz": self.rate(hello), "units": told, **keys})

    def _level_of(self, cascade: Cascade, group: str) -> int | None:
        """No finer than the cascade has this group, None where it has none of it."""
        detail = next((detail for detail in cascade.detail if detail.group == group), None)
        if detail is None:
            return min(self.level, cascade.levels - 1)
        if detail.rate_hz == 0:
            return None
        return max(min(self.level, cascade.levels - 1), detail.finest_level)


def _told(unit: Unit) -> dict[str, Any]:
    return {
        "cascade": unit.cascade,
        "level": unit.level,
        "class": unit.error,
        "group": unit.group,
        "codec": unit.codec,
    }


def _one_of(field: str, value: str, known: Sequence[str]) -> None:
    if value not in known:
        raise ValueError(f"{field} is {value!r}, must be one of {', '.join(known)}")
