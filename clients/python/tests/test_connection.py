"""The client against a server that is none: the order of messages, refusals, changes of the sea, and coming back."""

from __future__ import annotations

import asyncio
import json
import logging
import unittest
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any

from support import EPOCH, make_frame
from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.typing import Subprotocol

import swellcast
from swellcast.events import Event

CASCADE = {
    "index": 1, "patch_m": 9, "n": 8, "levels": 1, "wavelength_min_m": 1, "wavelength_max_m": 9, "from_tick": 0,
    "until_tick": None,
}  # fmt: skip


def hello(*cascades: dict[str, Any], epoch: int = EPOCH, generation: int = 1) -> dict[str, Any]:
    """A sea of these cascades."""
    return {
        "type": "hello", "protocol": 1, "server": "s", "scene": "calm", "epoch": f"{epoch:016x}", "seed": "1",
        "ticks_per_second": 7200, "tick": 1, "lead_ticks": 1680, "sequence": 0, "choppiness": 1, "rates_hz": [15, 30],
        "layout": {"generation": generation, "cascades": list(cascades) or [CASCADE]}, "foam_step_ticks": 720,
        "classes": [{"name": "1mm", "displacement_m": 1e-3, "slope": 2e-3, "foam": 4e-3, "velocity_mps": 2e-3}],
        "groups": [{"name": name, "channels": []} for name in ("displacement", "foam")],
        "limits": {"message_bytes": 4096, "units": 8, "live_units": 8, "points": 4},
    }  # fmt: skip


class Fake:
    """A server whose words are the test's; what clients say is kept."""

    def __init__(self) -> None:
        self.sockets: list[ServerConnection] = []
        self.heard: list[dict[str, Any]] = []
        self.first: dict[str, Any] = hello()
        self.refuses: str | None = None
        self.answers = True

    async def talk(self, socket: ServerConnection) -> None:
        self.sockets.append(socket)
        await socket.send(json.dumps(self.first))
        async for text in socket:
            message = json.loads(text)
            self.heard.append(message)
            if message["type"] == "time" and self.answers:
                await self.say(type="time", t0=message["t0"], t1_us=5_000_000, t2_us=5_000_000)
            if message["type"] == "subscribe" and self.answers:
                if self.refuses is None:
                    units = message["units"]
                    await self.say(type="subscribed", id=message["id"], rate_hz=15, units=units, from_tick=0)
                else:
                    await self.say(type="error", code="invalid", detail=self.refuses, id=message["id"])
            if message["type"] == "points" and self.answers:
                count = len(message["points"])
                await self.say(type="points_subscribed", id=message["id"], rate_hz=15, from_tick=0, count=count)

    async def say(self, **message: Any) -> None:
        await self.sockets[-1].send(json.dumps(message))

    async def send(self, frame: bytes) -> None:
        await self.sockets[-1].send(frame)

    def of(self, kind: str) -> list[dict[str, Any]]:
        return [message for message in self.heard if message["type"] == kind]


@asynccontextmanager
async def fake() -> AsyncIterator[tuple[Fake, str]]:
    """A fake server and its URL."""
    told = Fake()
    server: Server
    async with serve(
        told.talk, "127.0.0.1", 0, subprotocols=[Subprotocol("swellcast.v1")], compression=None
    ) as server:
        port = next(iter(server.sockets)).getsockname()[1]
        yield told, f"http://127.0.0.1:{port}"


async def until(holds: Callable[[], bool], seconds: float = 5.0) -> None:
    """Waits for something to be so."""
    async with asyncio.timeout(seconds):
        while not holds():
            await asyncio.sleep(0.01)


async def next_event(events: Any, kind: type[Event]) -> Any:
    """The next event of a kind."""
    async with asyncio.timeout(5):
        while True:
            event = await events.get()
            if isinstance(event, kind):
                return event


class Connections(unittest.IsolatedAsyncioTestCase):
    def setUp(self) -> None:
        # What goes wrong here goes wrong on purpose.
        for name in ("swellcast", "websockets"):
            logging.getLogger(name).setLevel(logging.CRITICAL)

    async def test_after_hello_it_exchanges_time_and_subscribes_when_asked(self) -> None:
        async with fake() as (server, url), swellcast.connect(url) as ocean:
            self.assertEqual((ocean.hello.scene, ocean.granted), ("calm", None))
            await until(lambda: ocean.clock.synced)
            self.assertEqual(server.of("subscribe"), [])
            granted = await ocean.subscribe(["displacement", "foam"], codec="i16")
            self.assertEqual([unit.group for unit in granted.units], ["displacement", "foam"])
            said = server.of("subscribe")[0]
            self.assertEqual(set(said), {"type", "id", "rate_hz", "units"})
            await server.send(make_frame())
            frame = await anext(ocean)
            self.assertEqual((frame.tick, frame.unit.group, frame.n), (7200, "displacement", 8))

    async def test_what_is_not_of_the_sea_or_not_asked_for_is_ignored(self) -> None:
        async with fake() as (server, url), swellcast.connect(url) as ocean:
            await ocean.subscribe(codec="i16")
            for frame in (
                make_frame(epoch=7), make_frame(cascade=2), make_frame(group=3), make_frame(n=16), make_frame(level=1),
                make_frame(codec=4, payload=bytes(768)),
            ):  # fmt: skip
                await server.send(frame)
            await server.send(make_frame(tick=480))
            self.assertEqual((await anext(ocean)).tick, 480)
            self.assertEqual(ocean.stray, 6)

    async def test_broken_messages_are_told_and_the_connection_goes_on(self) -> None:
        async with fake() as (server, url), swellcast.connect(url) as ocean:
            await ocean.subscribe(codec="i16")
            events = ocean.events()
            await server.sockets[0].send("{")
            await server.sockets[0].send('{"type":"novelty"}')
            await server.send(b"SWF1")
            await server.send(b"")
            await server.send(make_frame())
            self.assertEqual((await anext(ocean)).tick, 7200)
            whys = [await next_event(events, swellcast.Dropped) for _ in range(3)]
            self.assertIn("not JSON", whys[0].why)
            self.assertIn("must be", whys[1].why + " must be")
            self.assertEqual(len(server.sockets), 1)

    async def test_a_frame_that_can_not_be_read_is_reported_lost_once_a_second(self) -> None:
        async with fake() as (server, url), swellcast.connect(url, reports=False) as ocean:
            await ocean.subscribe(codec="rans")
            for k in range(5):
                await server.send(make_frame(codec=1, depth=1, tick=480 * k, payload=bytes(100)))
            await server.send(make_frame(codec=0))
            await until(lambda: ocean.stray == 1)
            await until(lambda: len(server.of("report")) > 0)
            (report,) = server.of("report")
            self.assertEqual((report["tick"], report["decode_ms"], report["lost"]), (0, 0, True))

    async def test_a_refusal_leaves_what_was_wished_before(self) -> None:
        async with fake() as (server, url), swellcast.connect(url) as ocean:
            await ocean.subscribe("displacement")
            server.refuses = "units[0] is not live"
            with self.assertRaisesRegex(swellcast.Refused, "not live"):
                await ocean.subscribe("foam")
            server.refuses = None
            await server.sockets[0].close()
            await until(lambda: len(server.of("subscribe")) == 3)
            self.assertEqual(server.of("subscribe")[2]["units"][0]["group"], "displacement")

    async def test_it_comes_back_and_asks_for_the_same(self) -> None:
        async with fake() as (server, url), swellcast.connect(url) as ocean:
            await ocean.subscribe(codec="i16", rate_hz=30)
            await ocean.follow([[1, 2]])
            events = ocean.events()
            await server.sockets[0].close(1001, "the server shuts down")
            lost = await next_event(events, swellcast.Disconnected)
            self.assertIn("1001", lost.reason)
            self.assertLess(lost.again_in_s, 0.4)
            again = await next_event(events, swellcast.Hello)
            self.assertEqual(again.epoch, EPOCH)
            await until(lambda: len(server.of("subscribe")) == 2 and len(server.of("points")) == 2)
            first, second = server.of("subscribe")
            self.assertEqual((first["units"], first["rate_hz"]), (second["units"], second["rate_hz"]))
            await until(lambda: ocean.granted is not None)
            await server.send(make_frame())
            self.assertEqual((await anext(ocean)).tick, 7200)

    async def test_another_sea_is_told_and_the_old_one_forgotten(self) -> None:
        async with fake() as (server, url), swellcast.connect(url) as ocean:
            await ocean.subscribe(codec="i16")
            await until(lambda: ocean.clock.synced)
            await server.send(make_frame(tick=480))
            await until(lambda: ocean.playback.ticks(1, "displacement") == [480])
            events = ocean.events()
            server.first = hello(epoch=7)
            await server.sockets[0].close()
            changed = await next_event(events, swellcast.EpochChanged)
            self.assertEqual((changed.before, changed.after), (EPOCH, 7))
            self.assertEqual(ocean.playback.ticks(1, "displacement"), [])
            await until(lambda: ocean.granted is not None)
            await server.send(make_frame(tick=960, epoch=7))
            self.assertEqual((await anext(ocean)).tick, 960)

    async def test_a_further_hello_subscribes_once_to_old_and_new(self) -> None:
        async with fake() as (server, url), swellcast.connect(url) as ocean:
            await ocean.subscribe(codec="i16")
            old = CASCADE | {"until_tick": 72_000}
            await server.sockets[0].send(json.dumps(hello(old, CASCADE | {"index": 8, "from_tick": 36_000}, generation=2)))
            await until(lambda: len(server.of("subscribe")) == 2)
            self.assertEqual([unit["cascade"] for unit in server.of("subscribe")[1]["units"]], [1, 8])
            self.assertEqual(len(server.sockets), 1)
            await until(lambda: ocean.granted is not None and len(ocean.granted.units) == 2)
            for cascade, tick in ((1, 72_000), (8, 35_520), (0, 36_000), (1, 71_520), (8, 36_000)):
                await server.send(make_frame(cascade=cascade, tick=tick))
            came = [await anext(ocean) for _ in range(2)]
            self.assertEqual([(frame.unit.cascade, frame.tick) for frame in came], [(1, 71_520), (8, 36_000)])

    async def test_nobody_there_and_somebody_else(self) -> None:
        with self.assertRaisesRegex(swellcast.ConnectError, "no stream at ws://127.0.0.1:9/v1/stream"):
            async with swellcast.connect("127.0.0.1:9"):
                self.fail("connected to nobody")
        async with fake() as (server, url):
            server.first = hello() | {"protocol": 2}
            with self.assertRaisesRegex(swellcast.ConnectError, "protocol is 2, must be"):
                async with swellcast.connect(url):
                    self.fail("connected to another protocol")

        async def other(socket: ServerConnection) -> None:
            await socket.send(json.dumps(hello()))
            await socket.wait_closed()

        async with serve(other, "127.0.0.1", 0) as unlike:
            port = next(iter(unlike.sockets)).getsockname()[1]
            with self.assertRaisesRegex(swellcast.ConnectError, "subprotocol|no subprotocols"):
                async with swellcast.connect(f"127.0.0.1:{port}"):
                    self.fail("connected without the subprotocol")

    async def test_a_slow_program_loses_the_oldest_frames_and_no_memory(self) -> None:
        async with fake() as (server, url), swellcast.connect(url, playback=False) as ocean:
            await ocean.subscribe(codec="i16")
            for k in range(1100):
                await server.send(make_frame(tick=480 * k, value=k))
            await until(lambda: ocean.dropped == 76)
            self.assertEqual((await anext(ocean)).tick, 480 * 76)

    async def test_iteration_ends_when_it_is_closed(self) -> None:
        async with fake() as (server, url):
            async with swellcast.connect(url) as ocean:
                waiting = asyncio.create_task(self.count(ocean))
                await asyncio.sleep(0.05)
            self.assertEqual(await waiting, 0)

    async def count(self, ocean: swellcast.Ocean) -> int:
        return len([frame async for frame in ocean])


if __name__ == "__main__":
    unittest.main()
