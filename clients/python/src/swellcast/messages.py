"""Text messages of the server (PROTOCOL.md section 3), each as a type; `parse` reads them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Detail:
    """How fine and how often a group of a cascade can be had: a rate of 0 is not at all, None any."""

    group: str
    finest_level: int
    rate_hz: int | None


@dataclass(frozen=True, slots=True)
class Cascade:
    """A square, periodic patch of water, and the ticks at which it is part of the sea."""

    index: int
    patch_m: float
    n: int
    levels: int
    wavelength_min_m: float
    wavelength_max_m: float
    from_tick: int
    until_tick: int | None
    detail: tuple[Detail, ...]

    def contains(self, tick: float) -> bool:
        """Whether it is part of the sea at a tick."""
        return self.from_tick <= tick and (self.until_tick is None or tick < self.until_tick)


@dataclass(frozen=True, slots=True)
class Layout:
    """The cascades of a sea: of one layout, or of two while it changes."""

    generation: int
    cascades: tuple[Cascade, ...]

    def ranks(self) -> dict[int, int]:
        """Of each cascade, by its index, its place in its layout: 0 has the longest waves."""
        ranks: dict[int, int] = {}
        seen: dict[tuple[int, int | None], int] = {}
        for cascade in self.cascades:
            life = (cascade.from_tick, cascade.until_tick)
            ranks[cascade.index] = seen.get(life, 0)
            seen[life] = ranks[cascade.index] + 1
        return ranks


@dataclass(frozen=True, slots=True)
class ErrorClass:
    """The guaranteed largest error of each kind of channel."""

    name: str
    displacement_m: float
    slope: float
    foam: float
    velocity_mps: float


@dataclass(frozen=True, slots=True)
class Group:
    """A group of channels that this scene has."""

    name: str
    channels: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Limits:
    """What a client must keep within."""

    message_bytes: int
    units: int
    live_units: int
    points: int


@dataclass(frozen=True, slots=True)
class Hello:
    """What sea this is. A further one of the same epoch: its layout will change."""

    server: str
    scene: str
    epoch: int
    seed: int
    tick: int
    lead_ticks: int
    sequence: int
    layout: Layout
    choppiness: float
    rates_hz: tuple[int, ...]
    classes: tuple[ErrorClass, ...]
    groups: tuple[Group, ...]
    foam_step_ticks: int
    limits: Limits

    def cascade(self, index: int) -> Cascade | None:
        """The cascade of an index."""
        return next((cascade for cascade in self.layout.cascades if cascade.index == index), None)


@dataclass(frozen=True, slots=True)
class GrantedUnit:
    """A unit that will be sent, with its rate where that is not the subscription's."""

    cascade: int
    level: int
    error: str
    group: str
    codec: str
    rate_hz: int | None


@dataclass(frozen=True, slots=True)
class Subscribed:
    """What will be sent, in the order asked."""

    id: int
    rate_hz: int
    units: tuple[GrantedUnit, ...]
    from_tick: int


@dataclass(frozen=True, slots=True)
class PointsSubscribed:
    """The first tick whose message of points will come, and how many points it has."""

    id: int
    rate_hz: int
    from_tick: int
    count: int


@dataclass(frozen=True, slots=True)
class TimeAnswer:
    """Server time, microseconds, when a request was read and when this answer was written."""

    t0: float
    t1_us: int
    t2_us: int


@dataclass(frozen=True, slots=True)
class Quality:
    """What is sent from now on where that is less than what was granted."""

    rate_hz: int
    coarser: int


@dataclass(frozen=True, slots=True)
class Wind:
    """The wind 10 m above the water, and where it comes from."""

    speed_mps: float
    direction_from_deg: float


@dataclass(frozen=True, slots=True)
class Status:
    """How the sea and the server are, once a second. A depth of infinity: infinitely deep."""

    tick: int
    sequence: int
    hs_m: float
    wind: Wind | None
    wind_range_mps: tuple[float, float] | None
    depth_m: float
    clients: int
    backend: str
    step_ms: float
    skipped_frames: int


@dataclass(frozen=True, slots=True)
class WaterChange:
    """What is None stays as it is."""

    depth_m: float | None
    gravity: float | None


@dataclass(frozen=True, slots=True)
class LayoutChange:
    """What was asked for; what came of it is in the hello that follows."""

    n: int | None
    band_limit: float
    finest_wavelength_m: float
    patches_m: tuple[float, ...]
    wind_range_mps: tuple[float, float] | None


@dataclass(frozen=True, slots=True)
class OtherChange:
    """A change that this client doesn't know."""

    kind: str
    fields: dict[str, Any]


@dataclass(frozen=True, slots=True)
class Change:
    """An entry of the control log: it begins to act at a tick, and takes so long."""

    sequence: int
    effective_tick: int
    transition_ticks: int
    change: Wind | WaterChange | LayoutChange | OtherChange


@dataclass(frozen=True, slots=True)
class ServerError:
    """A refusal."""

    code: str
    detail: str
    field: str | None
    id: int | None


ServerMessage = Hello | Subscribed | PointsSubscribed | TimeAnswer | Quality | Status | Change | ServerError
