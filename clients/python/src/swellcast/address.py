"""Where the stream and the HTTP side of a server are, from what people type."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final
from urllib.parse import urlsplit, urlunsplit

_STREAM: Final = "/v1/stream"
_SCHEMES: Final = {"http": ("ws", "http"), "ws": ("ws", "http"), "https": ("wss", "https"), "wss": ("wss", "https")}


@dataclass(frozen=True, slots=True)
class Address:
    """The URL of the stream, and what the paths of HTTP requests begin with."""

    stream: str
    http: str

    @staticmethod
    def of(url: str) -> Address:
        """Like http://host:port, ws://host:port/v1/stream or host:port."""
        bound = "must be like http://host:port or ws://host:port"
        try:
            parts = urlsplit(url if "://" in url else f"http://{url}")
            _ = parts.port
        except ValueError:
            raise ValueError(f"url is {url!r}, {bound}") from None
        if parts.scheme not in _SCHEMES or not parts.hostname or any(c.isspace() for c in url):
            raise ValueError(f"url is {url!r}, {bound}")
        socket, plain = _SCHEMES[parts.scheme]
        before = parts.path.rstrip("/").removesuffix(_STREAM)
        stream = urlunsplit((socket, parts.netloc, before + _STREAM, parts.query, ""))
        return Address(stream, urlunsplit((plain, parts.netloc, before, "", "")))
