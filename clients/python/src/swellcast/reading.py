"""JSON from the network, read field by field: each of the right type and within its bounds, or refused by name."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any, NoReturn, TypeVar

from .errors import MessageError
from .vocabulary import LAST_TICK

T = TypeVar("T")


def parse_object(text: str | bytes) -> dict[str, Any]:
    """A JSON object; raises MessageError for anything else."""
    try:
        value = json.loads(text, parse_constant=_no_number)
    except (ValueError, RecursionError) as error:
        raise MessageError(f"not JSON: {error}") from None
    if not isinstance(value, dict):
        raise MessageError(f"message is {_told(value)}, must be an object")
    return value


class Fields:
    """The fields of one JSON object."""

    def __init__(self, path: str, value: object) -> None:
        if not isinstance(value, dict):
            raise MessageError(f"{path} is {_told(value)}, must be an object")
        self._path = path
        self._values: dict[str, Any] = value

    def has(self, name: str) -> bool:
        """Whether the field is there, null included."""
        return name in self._values

    def is_null(self, name: str) -> bool:
        """Whether the field is there and null."""
        return self.has(name) and self._values[name] is None

    def integer(self, name: str, least: int = 0, most: int = LAST_TICK) -> int:
        """A whole number within bounds."""
        value = self._values.get(name)
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if not isinstance(value, int) or isinstance(value, bool) or not least <= value <= most:
            self._refuse(name, f"a whole number from {least} to {most}")
        return value

    def number(self, name: str, above: float = -math.inf) -> float:
        """A finite number above a bound."""
        return self._number(name, self._values.get(name), above)

    def text(self, name: str) -> str:
        """A text."""
        value = self._values.get(name)
        if not isinstance(value, str) or not _is_whole(value):
            self._refuse(name, "a text")
        return value

    def boolean(self, name: str) -> bool:
        """True or false."""
        value = self._values.get(name)
        if not isinstance(value, bool):
            self._refuse(name, "true or false")
        return value

    def texts(self, name: str) -> tuple[str, ...]:
        """An array of texts."""
        values = self._list(name)
        if not all(isinstance(value, str) and _is_whole(value) for value in values):
            self._refuse(name, "an array of texts")
        return tuple(values)

    def numbers(self, name: str, count: int | None = None) -> tuple[float, ...]:
        """An array of finite numbers, of so many where that is said."""
        values = self._list(name)
        if count is not None and len(values) != count:
            self._refuse(name, f"{count} numbers")
        return tuple(self._number(f"{name}[{i}]", value, -math.inf) for i, value in enumerate(values))

    def integers(self, name: str, least: int, most: int) -> tuple[int, ...]:
        """An array of whole numbers within bounds, one at least."""
        values = self._list(name)
        if not values or not all(isinstance(value, int) and not isinstance(value, bool) and least <= value <= most for value in values):
            self._refuse(name, f"whole numbers from {least} to {most}")
        return tuple(values)

    def one(self, name: str, read: Callable[[Fields], T]) -> T:
        """An object."""
        return read(Fields(f"{self._path}.{name}", self._values.get(name)))

    def each(self, name: str, read: Callable[[Fields], T]) -> tuple[T, ...]:
        """An array of objects; none where the field is absent is an error, too."""
        return tuple(read(Fields(f"{self._path}.{name}[{i}]", value)) for i, value in enumerate(self._list(name)))

    def optional(self, name: str, read: Callable[[str], T]) -> T | None:
        """What `read` makes of a field that may be absent or null."""
        return None if self._values.get(name) is None else read(name)

    def all(self) -> dict[str, Any]:
        """Everything, as it came."""
        return self._values

    def _list(self, name: str) -> list[Any]:
        value = self._values.get(name)
        if not isinstance(value, list):
            self._refuse(name, "an array")
        return value

    def _number(self, name: str, value: object, above: float) -> float:
        if isinstance(value, int) and not isinstance(value, bool) and abs(value) <= 2**63:
            value = float(value)
        if not isinstance(value, float) or not math.isfinite(value) or value <= above:
            bound = "a finite number" if above == -math.inf else f"a finite number above {above:g}"
            raise MessageError(f"{self._path}.{name} is {_told(value)}, must be {bound}")
        return value

    def _refuse(self, name: str, bound: str) -> NoReturn:
        found = _told(self._values[name]) if name in self._values else "missing"
        raise MessageError(f"{self._path}.{name} is {found}, must be {bound}")


def _no_number(name: str) -> NoReturn:
    raise ValueError(f"{name} is no number")


def _is_whole(text: str) -> bool:
    """Whether a text can be written: JSON lets half of a surrogate pair through."""
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def _told(value: object) -> str:
    """A value for people; what came from the network may be long."""
    if isinstance(value, list | dict):
        return f"{'an array' if isinstance(value, list) else 'an object'} of {len(value)}"
    try:
        text = repr(value)
    except ValueError:  # an integer of thousands of digits
        text = "a very long number"
    return text if len(text) <= 60 else text[:57] + "..."
