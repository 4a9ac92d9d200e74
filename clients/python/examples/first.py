"""The first frames of a sea: `python first.py http://127.0.0.1:8080`; ends with Ctrl-C."""

import asyncio
import sys

import swellcast


async def main(url: str) -> None:
    async with swellcast.connect(url) as ocean:
        await ocean.subscribe(["displacement", "foam"], cascades=[0, 1], error="1mm")
        print(ocean.hello.scene, ocean.status)
        async for frame in ocean:
            print(frame.tick, frame.unit.cascade, frame.unit.group, frame.planes.shape, frame.planes.std())
            if frame.unit.group == "displacement" and ocean.clock.synced:
                print("highest", frame["height"].max(), "m in", frame.time_s - ocean.clock.now(), "s")


asyncio.run(main(sys.argv[1]))
