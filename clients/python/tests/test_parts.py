"""The small parts: tiles put together, addresses, what is asked for, queues that are bounded."""

from __future__ import annotations

import asyncio
import dataclasses
import json
import unittest

import numpy as np
from support import make_frame, read_json
from test_playback import cascade_of, hello_of

from swellcast.address import Address
from swellcast.decode import Decoder
from swellcast.errors import MessageError
from swellcast.following import checked_points
from swellcast.frame import Frame
from swellcast.lane import Lane
from swellcast.messages import Detail, Group, Hello, Layout, Limits
from swellcast.parse import parse_server_message
from swellcast.patches import Patches
from swellcast.wish import Wish


def tile(x: int, z: int, tick: int = 480, level_n: int = 512) -> bytes:
    """A tile of foam whose counts say where it lies."""
    return make_frame(group=3, n=256, level_n=level_n, tile=(x, z), tick=tick, value=10 * z + x)


class Tiles(unittest.TestCase):
    def test_a_patch_of_four_tiles_in_any_order(self) -> None:
        patches, frame = Patches(1 << 22), None
        for x, z in ((1, 0), (0, 0), (1, 1), (0, 1)):
            self.assertIsNone(frame)
            frame = patches.add(Decoder(0).decode(tile(x, z)))
        assert frame is not None
        self.assertEqual((frame.n, frame["foam"].shape), (512, (512, 512)))
        assert frame.counts is not None
        self.assertEqual(frame.counts[0, ::256, ::256].tolist(), [[0, 1], [10, 11]])
        self.assertAlmostEqual(float(frame["foam"][300, 300]), 11 * 0.002, 6)

    def test_what_never_becomes_whole_is_dropped_and_counted(self) -> None:
        patches = Patches(1 << 22)
        for k in range(20):
            self.assertIsNone(patches.add(Decoder(0).decode(tile(0, 0, 480 * k))))
        self.assertEqual(patches.incomplete, 16)

    def test_a_huge_patch_holds_no_more_than_it_may(self) -> None:
        patches = Patches(8 * 65536)
        decoded = Decoder(0).decode(tile(0, 0, level_n=65280))
        for x in range(40):
            header = dataclasses.replace(decoded.header, tile_x=x)
            self.assertIsNone(patches.add(dataclasses.replace(decoded, header=header)))
        self.assertGreaterEqual(patches.incomplete, 4)


class Frames(unittest.TestCase):
    def test_values_are_counts_times_their_step(self) -> None:
        decoded = Decoder(0).decode(make_frame(group=1, value=-3))
        frame = Frame.of(decoded.header, decoded.counts, decoded.floats)
        self.assertEqual(frame.planes.dtype, np.float32)
        self.assertEqual(float(frame["slope_z"][0, 0]), float(np.float32(-3) * np.float32(0.002)))
        self.assertEqual((frame.channels, frame.time_s), (("slope_x", "slope_z"), 1.0))
        with self.assertRaises(KeyError):
            frame["height"]


class Addresses(unittest.TestCase):
    def test_what_people_type(self) -> None:
        for url, stream, http in (
            ("http://127.0.0.1:8080", "ws://127.0.0.1:8080/v1/stream", "http://127.0.0.1:8080"),
            ("http://127.0.0.1:8080/", "ws://127.0.0.1:8080/v1/stream", "http://127.0.0.1:8080"),
            ("ws://sea.example/v1/stream", "ws://sea.example/v1/stream", "http://sea.example"),
            ("localhost:9000", "ws://localhost:9000/v1/stream", "http://localhost:9000"),
            ("https://sea.example/bay", "wss://sea.example/bay/v1/stream", "https://sea.example/bay"),
            ("http://[::1]:8080", "ws://[::1]:8080/v1/stream", "http://[::1]:8080"),
        ):
            self.assertEqual(Address.of(url), Address(stream, http))
        for url in ("", "ftp://sea.example", "http://", "http:// ", "http://a:b"):
            with self.subTest(url), self.assertRaisesRegex(ValueError, "must be like"):
                Address.of(url)


class Wishes(unittest.TestCase):
    def wish(self, **over: object) -> Wish:
        usual = {"groups": ("height",), "cascades": None, "level": 0, "rate_hz": 15, "error": "1mm", "codec": "rans"}
        return Wish(**(usual | over))  # type: ignore[arg-type]

    def sea(self, *cascades: object, units: int = 64, message_bytes: int = 4096) -> Hello:
        base = hello_of(*cascades)  # type: ignore[arg-type]
        groups = (Group("height", ("height",)), Group("foam", ("foam",)))
        limits = Limits(message_bytes, units, 64, 10)
        return dataclasses.replace(base, groups=groups, limits=limits, rates_hz=(15, 30))

    def test_wrong_wishes_name_field_value_and_bound(self) -> None:
        sea = self.sea(cascade_of())
        for over, text in (
            ({"groups": ("hight",)}, "groups is 'hight', must be one of displacement"),
            ({"groups": ("slopes",)}, "groups is 'slopes', must be one of height, foam"),
            ({"error": "2mm"}, "error is '2mm', must be one of 0.5mm"),
            ({"codec": "zstd"}, "codec is 'zstd', must be one of i16"),
            ({"level": -1}, "level is -1, must be 0 to 255"),
            ({"rate_hz": 25}, r"rate_hz is 25, must be one of \[15, 30\]"),
            ({"cascades": frozenset({3})}, r"cascades are \[3\], each must be one of \[0\]"),
        ):
            with self.subTest(text), self.assertRaisesRegex(ValueError, text):
                self.wish(**over).check(sea)

    def test_cascades_are_places_in_each_layout(self) -> None:
        old = [cascade_of(index, 0, 9600) for index in (0, 1)]
        new = [cascade_of(index, 4800) for index in (8, 9, 10)]
        sea = self.sea(*old, *new)
        self.assertEqual([u.cascade for u in self.wish(cascades=frozenset({0})).units(sea)], [0, 8])
        self.assertEqual([u.cascade for u in self.wish(cascades=frozenset({2})).units(sea)], [10])
        self.assertEqual(len(self.wish(groups=("height", "foam")).units(sea)), 10)

    def test_levels_and_details_and_limits_are_kept(self) -> None:
        detail = (Detail("height", 1, 15), Detail("foam", 0, 0))
        cascade = dataclasses.replace(cascade_of(), detail=detail)
        units = self.wish(groups=("height", "foam")).units(self.sea(cascade))
        self.assertEqual([(u.group, u.level) for u in units], [("height", 1)])
        self.assertEqual(self.wish(level=9).units(self.sea(cascade_of()))[0].level, 1)
        many = [cascade_of(index) for index in range(64)]
        self.assertEqual(len(self.wish().units(self.sea(*many, units=5))), 5)
        sea = self.sea(*many, message_bytes=700)
        wish = self.wish()
        self.assertLessEqual(len(wish.message(1, sea, wish.units(sea))), 700)

    def test_the_text_is_what_the_protocol_says(self) -> None:
        sea = self.sea(cascade_of())
        wish = self.wish()
        unit = {"cascade": 1, "level": 0, "class": "1mm", "group": "height", "codec": "rans"}
        said = json.loads(wish.message(7, sea, wish.units(sea)))
        self.assertEqual(said, {"type": "subscribe", "id": 7, "rate_hz": 15, "units": [unit]})

    def test_points(self) -> None:
        self.assertEqual(checked_points([[1, 2], [3, 4]]).shape, (2, 2))
        self.assertEqual(checked_points([]).shape, (0, 2))
        for wrong in ([1, 2], [[1, 2, 3]], [[1, float("nan")]], [[2e9, 0]]):
            with self.assertRaises(ValueError):
                checked_points(wrong)


class Messages(unittest.TestCase):
    def test_a_hello_in_full(self) -> None:
        texts = [v["text"] for v in read_json("messages.json") if v["from"] == "server" and '"hello"' in v["text"]]
        hello = parse_server_message(texts[0])
        assert isinstance(hello, Hello)
        said = json.loads(texts[0])
        self.assertEqual((hello.scene, hello.epoch, hello.seed), ("beaufort-5", 0x0123456789ABCDEF, 2**64 - 1))
        self.assertEqual(len(hello.layout.cascades), len(said["layout"]["cascades"]))

    def test_each_field_of_a_hello_is_checked(self) -> None:
        text = next(v["text"] for v in read_json("messages.json") if v["from"] == "server" and '"hello"' in v["text"])
        said = json.loads(text)
        for field in said:
            if field == "type":
                continue
            odd: tuple[object, ...] = (None, [], {}, "x", -1, True, 1e300, "\ud800")
            for wrong in odd:
                broken = said | {field: wrong}
                with self.subTest(field, wrong=wrong):
                    try:
                        parse_server_message(json.dumps(broken))
                        # Few fields may be as odd as that.
                        self.assertIn(field, ("server", "scene", "choppiness", "classes", "groups"))
                    except MessageError as error:
                        self.assertIn(field, str(error))
            without = {name: value for name, value in said.items() if name != field}
            with self.subTest(field, wrong="missing"), self.assertRaisesRegex(MessageError, field):
                parse_server_message(json.dumps(without))

    def test_ranks(self) -> None:
        layout = Layout(2, (cascade_of(4, 0, 9600), cascade_of(5, 0, 9600), cascade_of(0, 4800)))
        self.assertEqual(layout.ranks(), {4: 0, 5: 1, 0: 0})


class Lanes(unittest.IsolatedAsyncioTestCase):
    async def test_the_oldest_is_dropped(self) -> None:
        lane: Lane[int] = Lane(3, 100)
        for i in range(5):
            lane.put(i, 10)
        self.assertEqual(([await lane.get() for _ in range(3)], lane.dropped), ([2, 3, 4], 2))
        lane.put(1, 60)
        lane.put(2, 60)
        self.assertEqual((await lane.get(), lane.dropped), (2, 3))
        lane.put(3, 1000)  # one is always let in
        self.assertEqual(await lane.get(), 3)

    async def test_it_ends(self) -> None:
        lane: Lane[int] = Lane(3, 100)
        lane.put(1)
        waiting = asyncio.create_task(self.all_of(lane))
        await asyncio.sleep(0)
        lane.end()
        self.assertEqual(await waiting, [1])
        broken: Lane[int] = Lane(3, 100)
        broken.end(ValueError("why"))
        with self.assertRaisesRegex(ValueError, "why"):
            await broken.get()

    async def all_of(self, lane: Lane[int]) -> list[int]:
        return [thing async for thing in lane]


if __name__ == "__main__":
    unittest.main()
