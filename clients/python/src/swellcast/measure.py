"""Measures what decoding takes on this machine: `python -m swellcast.measure --url URL`.

For each codec it keeps what the server sends of three groups of the first cascade, and then decodes that without the
network. Times are of the processor, so that what else runs on the machine counts as little as it can.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import statistics
import sys
import time
from typing import Final

from websockets.asyncio.client import connect
from websockets.exceptions import WebSocketException
from websockets.typing import Subprotocol

from .address import Address
from .decode import Decoder
from .errors import SwellcastError
from .header import LONGEST_FRAME, read_header
from .messages import Hello
from .parse import parse_server_message
from .vocabulary import MOST_SAMPLES, SLOWEST_INTERVAL, SUBPROTOCOL, TICKS_PER_SECOND, layer_of
from .wish import Wish

_GROUPS: Final = ("displacement", "slopes", "derivatives")
_CODECS: Final = ("i16", "f16", "f32", "deflate", "rans")


async def recorded(stream: str, codec: str, error: str, ticks: int) -> list[bytes]:
    """All frames of so many ticks at 15 Hz, as they came."""
    frames: list[bytes] = []
    subprotocols = [Subprotocol(SUBPROTOCOL)]
    async with connect(stream, subprotocols=subprotocols, compression=None, max_size=LONGEST_FRAME) as socket:
        hello = parse_server_message(str(await socket.recv()))
        if not isinstance(hello, Hello):
            raise SwellcastError("the server does not say hello first")
        had = {group.name for group in hello.groups}
        wish = Wish(tuple(g for g in _GROUPS if g in had), frozenset({0}), 0, None, error, codec)
        await socket.send(wish.message(1, hello, wish.units(hello)))
        async with asyncio.timeout(30 + ticks / 15):
            seen: set[int] = set()
            while len(seen) <= ticks:
                message = await socket.recv()
                if isinstance(message, bytes):
                    frames.append(message)
                    seen.add(read_header(message).tick)
        await socket.send(json.dumps({"type": "subscribe", "id": 2, "rate_hz": hello.rates_hz[0], "units": []}))
    return frames


def decoded(frames: list[bytes]) -> dict[int, list[float]]:
    """What the frames of each tick take, seconds: by the least depth of them, 0 for a beginning and 1 for all else."""
    decoder, times, depths = Decoder(MOST_SAMPLES), dict[int, float](), dict[int, int]()
    for frame in frames:
        began = time.process_time()
        tile = decoder.decode(frame)
        tick = tile.header.tick
        times[tick] = times.get(tick, 0.0) + time.process_time() - began
        depths[tick] = min(1, tile.header.depth)
        assert layer_of(tick) == 0
    found: dict[int, list[float]] = {}
    for tick, seconds in times.items():
        found.setdefault(depths[tick], []).append(seconds)
    return found


async def measure(url: str, error: str, ticks: int) -> None:
    """Prints a table."""
    stream = Address.of(url).stream
    print(f"{', '.join(_GROUPS)} of one cascade, class {error}; decoding all of a tick, ms of one core")
    print(f"{'codec':8} {'KB a tick':>10} {'usual':>8} {'slowest':>8} {'a beginning':>12}   of {1000 / 15:.0f} ms at 15 Hz")
    for codec in _CODECS:
        frames = await recorded(stream, codec, error, ticks)
        times = decoded(frames)
        usual = times.get(1) or times[0]
        kilobytes = sum(map(len, frames)) / 1e3 / max(1, len(times.get(0, [])) + len(times.get(1, [])))
        median, slowest = statistics.median(usual) * 1e3, max(usual) * 1e3
        begins = max(times.get(0, [0.0])) * 1e3
        share = median / (1e3 * SLOWEST_INTERVAL / TICKS_PER_SECOND)
        print(f"{codec:8} {kilobytes:10.0f} {median:8.2f} {slowest:8.2f} {begins:12.1f}   {share:.0%}", flush=True)


def main() -> int:
    """The command."""
    parser = argparse.ArgumentParser("python -m swellcast.measure", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--url", required=True, help="of the server, like http://127.0.0.1:8080")
    parser.add_argument("--class", dest="error", default="1mm", help="error class (default 1mm)")
    parser.add_argument("--ticks", type=int, default=60, help="of each codec (default 60)")
    asked = parser.parse_args()
    try:
        asyncio.run(measure(asked.url, asked.error, asked.ticks))
    except (SwellcastError, ValueError, OSError, WebSocketException) as error:
        print(f"swellcast.measure: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
