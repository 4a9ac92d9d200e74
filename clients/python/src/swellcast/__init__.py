"""Python client of Swellcast: one simulated ocean, streamed to many."""

from .clock import Clock
from .errors import (
    ConnectError,
    FrameError,
    HttpError,
    MessageError,
    MissingError,
    PayloadError,
    Refused,
    SwellcastError,
)
from .events import Disconnected, Dropped, EpochChanged, Event
from .frame import Frame
from .http import Accepted, Probe, Statistics
from .messages import (
    Cascade,
    Change,
    GrantedUnit,
    Hello,
    Layout,
    LayoutChange,
    OtherChange,
    Quality,
    ServerError,
    Status,
    Subscribed,
    WaterChange,
    Wind,
)
from .ocean import DEFAULT_CODEC, Ocean, connect
from .playback import Playback, Sample
from .points import PointsFrame
from .vocabulary import CLASSES, CODECS, GROUPS, TICKS_PER_SECOND, Unit

__all__ = [
    "CLASSES",
    "CODECS",
    "DEFAULT_CODEC",
    "GROUPS",
    "TICKS_PER_SECOND",
    "Accepted",
    "Cascade",
    "Change",
    "Clock",
    "ConnectError",
    "Disconnected",
    "Dropped",
    "EpochChanged",
    "Event",
    "Frame",
    "FrameError",
    "GrantedUnit",
    "Hello",
    "HttpError",
    "Layout",
    "LayoutChange",
    "MessageError",
    "MissingError",
    "Ocean",
    "OtherChange",
    "PayloadError",
    "Playback",
    "PointsFrame",
    "Probe",
    "Quality",
    "Refused",
    "Sample",
    "ServerError",
    "Status",
    "Subscribed",
    "SwellcastError",
    "Unit",
    "WaterChange",
    "Wind",
    "connect",
]
