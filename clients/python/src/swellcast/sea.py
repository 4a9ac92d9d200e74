"""What a client holds of a sea: what it heard, and where each frame of it goes.

Told by the link; asked by the program. Of another sea, or of what is no more subscribed to, nothing passes.
"""

from __future__ import annotations

import itertools
import logging
from collections.abc import Callable
from typing import Final
from weakref import WeakSet

from .clock import Clock
from .decode import Tile
from .events import Disconnected, Dropped, EpochChanged, Event
from .following import Following
from .frame import Frame
from .lane import Lane
from .messages import Change, Hello, PointsSubscribed, Quality, ServerError, ServerMessage, Status, Subscribed
from .patches import Patches
from .playback import Playback
from .points import PointsFrame
from .subscription import Subscription
from .vocabulary import MOST_SAMPLES

_LOG: Final = logging.getLogger("swellcast")
#: Frames, messages of points and events that wait for the program; what is older is dropped.
_MOST_FRAMES: Final = 1024
_MOST_EVENTS: Final = 256


class Sea:
    """Bounded: what the program does not take in time is dropped, and counted."""

    def __init__(self, clock: Clock, post: Callable[[str], None], keeps: bool) -> None:
        self._clock = clock
        self._post = post
        self._keeps = keeps
        self.hello: Hello | None = None
        self.status: Status | None = None
        self.quality: Quality | None = None
        self.playback = Playback()
        ids = itertools.count(1)
        self.subscription = Subscription(ids)
        self.following = Following(ids)
        self.patches = Patches(MOST_SAMPLES)
        self.frames: Lane[Frame] = Lane(_MOST_FRAMES, MOST_SAMPLES)
        self.points: Lane[PointsFrame] = Lane(_MOST_FRAMES, MOST_SAMPLES)
        self._events: WeakSet[Lane[Event]] = WeakSet()
        #: Frames of another sea or subscription, which were ignored.
        self.stray = 0

    @property
    def greeted(self) -> bool:
        """Whether a server has ever said what sea it has."""
        return self.hello is not None

    def events(self) -> Lane[Event]:
        """All events from now on, as long as somebody holds this."""
        lane: Lane[Event] = Lane(_MOST_EVENTS, 1)
        self._events.add(lane)
        return lane

    def end(self, error: BaseException | None) -> None:
        """Nothing more will come."""
        self.frames.end(error)
        self.points.end(error)
        for lane in self._events:
            lane.end(error)

    def heard(self, message: ServerMessage) -> None:
        """A text message."""
        match message:
            case Hello():
                self._begin(message)
            case PointsSubscribed():
                self.following.request.answer(message.id, message)
                return
            case Status():
                self.status = message
            case Quality():
                self.quality = message
            case ServerError():
                waited = self.subscription.request.refuse(message) or self.following.request.refuse(message)
                if not waited:
                    _LOG.warning("the server refuses: %s", message.detail)
            case Change():
                pass
            case _:
                return
        self._tell(message)

    def subscribed(self, message: Subscribed) -> None:
        """The answer to a subscription."""
        self.quality = None
        self.playback.retain(self.subscription.take(message))

    def came(self, tile: Tile) -> None:
        """A frame of any sea."""
        if self.hello is None or not self.subscription.fits(tile.header, self.hello):
            self.stray += 1
            return
        frame = self.patches.add(tile)
        if frame is not None:
            if self._keeps:
                self.playback.add(frame)
            self.frames.put(frame, frame.data.size)

    def points_came(self, points: PointsFrame) -> None:
        """A message of points of any sea."""
        if self.hello is not None and self.following.fits(points, self.hello):
            self.points.put(points, len(points.height))

    def dropped(self, why: str) -> None:
        """A message that could not be read."""
        _LOG.warning("dropped a message: %s", why)
        self._tell(Dropped(why))

    def lost(self, reason: str, again_in_s: float) -> None:
        """There is no connection for so long at least."""
        _LOG.warning("%s; again in %.1f s", reason, again_in_s)
        self.subscription.lose()
        self.patches.clear()
        self._tell(Disconnected(reason, again_in_s))

    def send_subscription(self) -> None:
        """Asks for what is wished of this sea; without a sea, when there is one."""
        self._send(self.subscription.message)

    def send_points(self) -> None:
        """The same of points."""
        self._send(self.following.message)

    def _begin(self, hello: Hello) -> None:
        before, self.hello = self.hello, hello
        same_sea = before is not None and before.epoch == hello.epoch
        self.playback.begin(hello, same_sea)
        if before is not None and not same_sea:
            self._clock.reset()
            self.frames.clear()
            self.points.clear()
            self.patches.clear()
            self._tell(EpochChanged(before.epoch, hello.epoch))
        self.send_subscription()
        self.send_points()

    def _send(self, message_of: Callable[[Hello], str | None]) -> None:
        text = None if self.hello is None else message_of(self.hello)
        if text is not None:
            self._post(text)

    def _tell(self, event: Event) -> None:
        for lane in self._events:
            lane.put(event)
