"""What can go wrong, each kind with a type of its own."""

from __future__ import annotations

from typing import Any


class SwellcastError(Exception):
    """Any error of this package."""


class FrameError(SwellcastError):
    """A binary message that must be dropped; the text says why."""


class MissingError(FrameError):
    """A frame that is predicted from one that is not held: its unit must begin anew."""


class PayloadError(FrameError):
    """A frame whose header is right and whose payload is not: what follows can't be predicted from it."""


class MessageError(SwellcastError):
    """A text message that can't be used; the text names field, value and bound."""


class ConnectError(SwellcastError):
    """There is no stream at the URL."""


class ProtocolError(SwellcastError):
    """The server speaks another protocol."""


class Refused(SwellcastError):
    """The server refused a request over the stream."""

    def __init__(self, code: str, detail: str, field: str | None = None) -> None:
        super().__init__(detail)
        self.code = code
        self.field = field


class HttpError(SwellcastError):
    """The server refused a request over HTTP; `problem` is its RFC 9457 document, where it sent one."""

    def __init__(self, status: int, text: str, problem: dict[str, Any]) -> None:
        super().__init__(text)
        self.status = status
        self.problem = problem
