"""The HTTP side of a server: probes, changes and statistics, by the standard library in a thread."""

from __future__ import annotations

import asyncio
import http.client
import json
import urllib.error
import urllib.request
from dataclasses import dataclass
from typing import Any, Final
from urllib.parse import quote

import numpy as np
from numpy.typing import NDArray

from .errors import HttpError, MessageError, SwellcastError
from .reading import Fields, parse_object
from .vocabulary import TICKS_PER_SECOND

#: How long an answer may take: building a change of a large sea takes seconds on a busy machine.
_PATIENCE_S: Final = 15.0
#: Largest answer taken; ten thousand points are 4 MiB.
_MOST_BYTES: Final = 16 << 20


@dataclass(frozen=True, slots=True)
class Accepted:
    """A change that was accepted: its place in the control log, and the tick at which it begins to act."""

    sequence: int
    effective_tick: int


@dataclass(frozen=True, slots=True)
class Statistics:
    """What the sea is like, from the energies of its modes. What is None has no value in a sea like this."""

    tick: int
    hs_m: float
    wanted_hs_m: float
    m0_m2: float
    tp_s: float | None
    tz_s: float | None
    sea_state: int
    steepness: float | None
    mean_square_slope: float
    direction_from_deg: float | None
    spread_deg: float | None
    foam_coverage: float
    folded_fraction: float


@dataclass(frozen=True, eq=False, slots=True)
class Probe:
    """The water at points of the world at one tick, in the order asked. What was not asked for is None."""

    tick: int
    sequence: int
    method: str
    points: NDArray[np.float64]
    #: Of the displaced surface above each point, metres.
    height: NDArray[np.float64]
    #: Unit vectors (east, up, south), [point][3].
    normal: NDArray[np.float64] | None
    #: Of the water there, m/s, [point][3].
    velocity: NDArray[np.float64] | None
    jacobian: NDArray[np.float64] | None
    folded: NDArray[np.bool_]
    #: Distance between the point and where the particle found is, metres.
    residual: NDArray[np.float64]

    @property
    def time_s(self) -> float:
        """Seconds since the sea began."""
        return self.tick / TICKS_PER_SECOND


async def ask(base: str, method: str, path: str, body: dict[str, Any] | None = None) -> dict[str, Any]:
    """Sends a request and gives the object it is answered with; raises HttpError for a refusal."""
    return await asyncio.to_thread(_ask, base + path, method, body)


def path_of(scene: str, what: str = "") -> str:
    """The path of something that a scene has."""
    return f"/v1/scenes/{quote(scene, safe='')}{what}"


def accepted(answer: dict[str, Any]) -> Accepted:
    """Reads the answer to a change."""
    f = Fields("change", answer)
    return Accepted(f.integer("sequence"), f.integer("effective_tick"))


def statistics(answer: dict[str, Any]) -> Statistics:
    """Reads the statistics of a scene."""
    f = Fields("statistics", answer)
    return Statistics(
        tick=f.integer("tick"),
        hs_m=f.number("hs_m"),
        wanted_hs_m=f.number("wanted_hs_m"),
        m0_m2=f.number("m0_m2"),
        tp_s=f.optional("tp_s", f.number),
        tz_s=f.optional("tz_s", f.number),
        sea_state=f.integer("sea_state"),
        steepness=f.optional("steepness", f.number),
        mean_square_slope=f.number("mean_square_slope"),
        direction_from_deg=f.optional("direction_from_deg", f.number),
        spread_deg=f.optional("spread_deg", f.number),
        foam_coverage=f.number("foam_coverage"),
        folded_fraction=f.number("folded_fraction"),
    )


def probe(answer: dict[str, Any], asked: NDArray[np.float64]) -> Probe:
    """Reads the answer to a probe of these points."""
    f = Fields("probe", answer)
    rows = f.each("points", lambda row: row)
    if len(rows) != len(asked):
        raise MessageError(f"probe.points are {len(rows)}, must be {len(asked)}")

    def numbers(name: str) -> NDArray[np.float64]:
        return np.asarray([row.number(name) for row in rows], np.float64)

    def vectors(name: str) -> NDArray[np.float64] | None:
        there = all(row.has(name) for row in rows)
        return np.asarray([row.numbers(name, 3) for row in rows], np.float64) if there else None

    return Probe(
        tick=f.integer("tick"),
        sequence=f.integer("sequence"),
        method=f.text("method"),
        points=asked,
        height=numbers("height"),
        normal=vectors("normal"),
        velocity=vectors("velocity"),
        jacobian=numbers("jacobian") if all(row.has("jacobian") for row in rows) else None,
        folded=np.asarray([row.boolean("folded") for row in rows], np.bool_),
        residual=numbers("residual"),
    )


def _ask(url: str, method: str, body: dict[str, Any] | None) -> dict[str, Any]:
    data = None if body is None else json.dumps(body, allow_nan=False).encode()
    request = urllib.request.Request(url, data, {"Content-Type": "application/json"}, method=method)
    try:
        with urllib.request.urlopen(request, timeout=_PATIENCE_S) as answer:
            text = answer.read(_MOST_BYTES + 1)
    except urllib.error.HTTPError as error:
        with error:
            raise _refusal(url, method, error) from None
    except (OSError, http.client.HTTPException) as error:
        raise SwellcastError(f"{method} {url}: {error}") from error
    if len(text) > _MOST_BYTES:
        raise SwellcastError(f"{method} {url}: the answer is above {_MOST_BYTES} bytes")
    return parse_object(text)


def _refusal(url: str, method: str, error: urllib.error.HTTPError) -> HttpError:
    try:
        problem = parse_object(error.read(1 << 16))
    except (MessageError, OSError, http.client.HTTPException):
        problem = {}
    detail = problem.get("detail") or error.reason
    return HttpError(error.code, f"{method} {url}: {error.code}: {detail}", problem)
