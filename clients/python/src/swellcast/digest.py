"""Prints what was decoded, one line of JSON a tick: `python -m swellcast.digest --url URL --seconds S`.

Any two clients of the same unit print the same digest of the same tick, whatever language they are written in and
whatever codec carried the counts. The digest is the CRC-32 of the little-endian 16-bit counts, channels in order, each
row by row over the whole patch.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import logging
import sys
import time
import zlib

from .errors import SwellcastError
from .frame import Frame
from .ocean import connect
from .vocabulary import CLASSES, GROUP_NAMES


def digest_of(frame: Frame) -> str:
    """Eight hexadecimal digits."""
    if frame.counts is None:
        raise ValueError(f"codec is {frame.unit.codec}, must be one of counts")
    return f"{zlib.crc32(frame.counts.astype('<i2', copy=False).tobytes()):08x}"


async def print_digests(
    url: str, seconds: float, group: str, cascade: int, rate_hz: int, error: str, codec: str
) -> int:
    """Prints for so many seconds after the first frame; gives how many lines."""
    lines, begun = 0, False
    # Without reports: it is told late rather than less.
    async with connect(url, playback=False, reports=False) as ocean:
        granted = await ocean.subscribe(group, [cascade], rate_hz=rate_hz, error=error, codec=codec)
        if not granted.units:
            raise SwellcastError(f"{ocean.hello.scene} has no {group} of cascade {cascade}")
        ends = time.monotonic() + seconds
        async with asyncio.timeout(seconds + 10) as patience:
            async for frame in ocean:
                if not begun:
                    begun, ends = True, time.monotonic() + seconds
                    patience.reschedule(asyncio.get_running_loop().time() + seconds + 10)
                # The server spares a client that falls behind: its coarser frames are none of this unit.
                if frame.unit.level == granted.units[0].level:
                    print(json.dumps({"tick": frame.tick, "digest": digest_of(frame)}), flush=True)
                    lines += 1
                if time.monotonic() >= ends:
                    break
    return lines


def main() -> int:
    """The command; its exit status is 0 when there was a frame."""
    parser = argparse.ArgumentParser("python -m swellcast.digest", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--url", required=True, help="of the server, like http://127.0.0.1:8080")
    parser.add_argument("--seconds", type=float, default=5.0, help="how long to print (default 5)")
    parser.add_argument("--group", default="displacement", choices=GROUP_NAMES)
    parser.add_argument("--cascade", type=int, default=0, help="0 has the longest waves (default)")
    parser.add_argument("--rate", type=int, default=15, help="frames a second (default 15)")
    parser.add_argument("--class", dest="error", default="5mm", choices=CLASSES)
    parser.add_argument("--codec", default="rans", choices=("i16", "rans", "deflate"))
    asked = parser.parse_args()
    logging.basicConfig(level=logging.WARNING, stream=sys.stderr)
    try:
        lines = asyncio.run(
            print_digests(
                asked.url, asked.seconds, asked.group, asked.cascade, asked.rate, asked.error, asked.codec
            )
        )
    except (SwellcastError, ValueError, TimeoutError) as error:
        print(f"swellcast.digest: {error or 'no frame in time'}", file=sys.stderr)
        return 1
    return 0 if lines else 1


if __name__ == "__main__":
    sys.exit(main())
