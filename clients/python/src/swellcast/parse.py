"""Reads the text messages of the server (PROTOCOL.md section 3): every field checked, unknown ones ignored."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Final

from .errors import MessageError
from .messages import (
    Cascade,
    Change,
    Detail,
    ErrorClass,
    GrantedUnit,
    Group,
    Hello,
    Layout,
    LayoutChange,
    Limits,
    OtherChange,
    PointsSubscribed,
    Quality,
    ServerError,
    ServerMessage,
    Status,
    Subscribed,
    TimeAnswer,
    WaterChange,
    Wind,
)
from .reading import Fields, parse_object
from .vocabulary import TICKS_PER_SECOND

#: No server sends frames longer before their ticks: 10 s.
_LONGEST_LEAD: Final = 10 * TICKS_PER_SECOND
#: Microseconds beyond this are nobody's.
_MOST_US: Final = 2**60
#: The most that 64 bits hold.
_U64: Final = 2**64 - 1


def parse_server_message(text: str) -> ServerMessage | None:
    """Reads a message; None for a type that this client doesn't know. Raises MessageError."""
    message = parse_object(text)
    kind = Fields("message", message).text("type")
    reader = _READERS.get(kind)
    return None if reader is None else reader(Fields(kind, message))


def _hello(f: Fields) -> Hello:
    f.integer("protocol", 1, 1)
    f.integer("ticks_per_second", TICKS_PER_SECOND, TICKS_PER_SECOND)
    return Hello(
        server=f.text("server"),
        scene=f.text("scene"),
        epoch=_digits(f, "epoch", "[0-9a-fA-F]{16}", 16, "16 hexadecimal digits"),
        seed=_digits(f, "seed", "[0-9]{1,20}", 10, "decimal digits"),
        tick=f.integer("tick"),
        lead_ticks=f.integer("lead_ticks", 0, _LONGEST_LEAD),
        sequence=f.integer("sequence", 0, _U64),
        layout=f.one("layout", _layout),
        choppiness=f.number("choppiness"),
        rates_hz=f.integers("rates_hz", 1, TICKS_PER_SECOND),
        classes=f.each("classes", _class),
        groups=f.each("groups", lambda g: Group(g.text("name"), g.texts("channels"))),
        foam_step_ticks=f.integer("foam_step_ticks"),
        limits=f.one("limits", _limits),
    )


def _digits(f: Fields, name: str, form: str, base: int, bound: str) -> int:
    text = f.text(name)
    if not re.fullmatch(form, text):
        raise MessageError(f"hello.{name} is {text[:40]!r}, must be {bound}")
    return int(text, base)


def _layout(f: Fields) -> Layout:
    return Layout(f.integer("generation"), f.each("cascades", _cascade))


def _cascade(f: Fields) -> Cascade:
    return Cascade(
        index=f.integer("index", 0, 255),
        patch_m=f.number("patch_m", above=0),
        n=f.integer("n", 1, 65535),
        levels=f.integer("levels", 1, 255),
        wavelength_min_m=f.number("wavelength_min_m", above=0),
        wavelength_max_m=f.number("wavelength_max_m", above=0),
        from_tick=f.integer("from_tick"),
        until_tick=f.optional("until_tick", f.integer),
        detail=f.each("detail", _detail) if f.has("detail") else (),
    )


def _detail(f: Fields) -> Detail:
    return Detail(f.text("group"), f.integer("finest_level", 0, 255), f.optional("rate_hz", f.integer))


def _class(f: Fields) -> ErrorClass:
    return ErrorClass(
        f.text("name"), f.number("displacement_m"), f.number("slope"), f.number("foam"), f.number("velocity_mps")
    )


def _limits(f: Fields) -> Limits:
    return Limits(
        message_bytes=f.integer("message_bytes"),
        units=f.integer("units"),
        live_units=f.integer("live_units"),
        points=f.optional("points", f.integer) or 0,
    )


def _subscribed(f: Fields) -> Subscribed:
    return Subscribed(f.integer("id"), f.integer("rate_hz", 1), f.each("units", _unit), f.integer("from_tick"))


def _unit(f: Fields) -> GrantedUnit:
    return GrantedUnit(
        cascade=f.integer("cascade", 0, 255),
        level=f.integer("level", 0, 255),
        error=f.text("class"),
        group=f.text("group"),
        codec=f.optional("codec", f.text) or "i16",
        rate_hz=f.optional("rate_hz", f.integer),
    )


def _points_subscribed(f: Fields) -> PointsSubscribed:
    return PointsSubscribed(f.integer("id"), f.integer("rate_hz", 1), f.integer("from_tick"), f.integer("count"))


def _time(f: Fields) -> TimeAnswer:
    return TimeAnswer(f.number("t0"), f.integer("t1_us", -_MOST_US, _MOST_US), f.integer("t2_us", -_MOST_US, _MOST_US))


def _quality(f: Fields) -> Quality:
    return Quality(f.integer("rate_hz", 1), f.integer("coarser", 0, 255))


def _wind(f: Fields) -> Wind:
    return Wind(f.number("speed_mps"), f.number("direction_from_deg"))


def _status(f: Fields) -> Status:
    return Status(
        tick=f.integer("tick"),
        sequence=f.integer("sequence", 0, _U64),
        hs_m=f.number("hs_m"),
        wind=f.optional("wind", lambda name: f.one(name, _wind)),
        wind_range_mps=f.optional("wind_range_mps", lambda name: _pair(f, name)),
        depth_m=math.inf if f.is_null("depth_m") else f.number("depth_m"),
        clients=f.integer("clients"),
        backend=f.text("backend"),
        step_ms=f.number("step_ms"),
        skipped_frames=f.integer("skipped_frames", 0, _U64),
    )


def _pair(f: Fields, name: str) -> tuple[float, float]:
    low, high = f.numbers(name, 2)
    return low, high


def _change(f: Fields) -> Change:
    return Change(
        sequence=f.integer("sequence", 0, _U64),
        effective_tick=f.integer("effective_tick"),
        transition_ticks=f.integer("transition_ticks"),
        change=f.one("change", _kind_of_change),
    )


def _kind_of_change(f: Fields) -> Wind | WaterChange | LayoutChange | OtherChange:
    match f.text("kind"):
        case "wind":
            return _wind(f)
        case "water":
            depth_m = math.inf if f.is_null("depth_m") else f.optional("depth_m", f.number)
            return WaterChange(depth_m, f.optional("gravity", f.number))
        case "layout":
            return LayoutChange(
                n=f.optional("n", f.integer),
                band_limit=f.number("band_limit"),
                finest_wavelength_m=f.number("finest_wavelength_m"),
                patches_m=f.numbers("patches_m"),
                wind_range_mps=f.optional("wind_range_mps", lambda name: _pair(f, name)),
            )
        case kind:
            return OtherChange(kind, f.all())


def _error(f: Fields) -> ServerError:
    return ServerError(f.text("code"), f.text("detail"), f.optional("field", f.text), f.optional("id", f.integer))


_READERS: Final[dict[str, Callable[[Fields], ServerMessage]]] = {
    "hello": _hello,
    "subscribed": _subscribed,
    "points_subscribed": _points_subscribed,
    "time": _time,
    "quality": _quality,
    "status": _status,
    "change": _change,
    "error": _error,
}
