"""Names and numbers of the wire (PROTOCOL.md section 5)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

SUBPROTOCOL: Final = "swellcast.v1"
TICKS_PER_SECOND: Final = 7200
#: A JavaScript number holds every tick exactly.
LAST_TICK: Final = 2**53 - 1
#: Ticks between frames of the lowest rate.
SLOWEST_INTERVAL: Final = 480
#: Frames of the lowest rate that a prediction may reach back to.
MAX_DEPTH: Final = 3
#: Depth of a frame that is predicted from those on both sides of it.
BETWEEN: Final = 4
#: Samples a side of the largest tile.
TILE: Final = 256
#: A cascade that ends is zero for this long before its last tick.
REST_TICKS: Final = 1440
#: Most samples of one moment that are held, all units together: nine channels of three patches of 1024 x 1024 fit.
MOST_SAMPLES: Final = 2**25

#: Error classes; their place is their number on the wire. So it is in the two tables that follow.
CLASSES: Final = ("0.5mm", "1mm", "5mm", "20mm")
CODECS: Final = ("i16", "rans", "deflate", "f16", "f32")
#: Groups, each with its channels in order.
GROUPS: Final[dict[str, tuple[str, ...]]] = {
    "displacement": ("dx", "height", "dz"),
    "slopes": ("slope_x", "slope_z"),
    "derivatives": ("dxx", "dzz", "dxz"),
    "foam": ("foam",),
    "height": ("height",),
    "velocity": ("velocity_x", "velocity_y", "velocity_z"),
    "jacobian": ("jacobian", "eigenvalue"),
    "stretch": ("dxx", "dzz"),
    "normals": ("normal_x", "normal_z"),
}
GROUP_NAMES: Final = tuple(GROUPS)
#: Codecs that send what a prediction leaves, and those that send floats.
PREDICTING: Final = frozenset({"rans", "deflate"})
FLOATS: Final = frozenset({"f16", "f32"})


@dataclass(frozen=True, slots=True)
class Unit:
    """What is encoded and sent once for all clients."""

    cascade: int
    level: int
    error: str
    group: str
    codec: str


def layer_of(tick: int) -> int:
    """The layer of a tick in time: 0, 1 and 2 come at 15, 30 and 60 Hz; 3 is no frame's."""
    for layer in range(3):
        if tick % (SLOWEST_INTERVAL >> layer) == 0:
            return layer
    return 3
