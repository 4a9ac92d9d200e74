"""Every vector of the repository: each frame decodes to what stands beside it, every wrong one is refused."""

from __future__ import annotations

import json
import unittest
import zlib
from typing import Any

import numpy as np
from support import VECTORS, read_bytes, read_json, split_stream

from swellcast.clock import Clock, Exchange
from swellcast.decode import Decoder, Tile
from swellcast.errors import FrameError, MessageError
from swellcast.parse import parse_server_message
from swellcast.points import read_points


def crcs(tile: Tile) -> list[int]:
    """CRC-32 of each channel."""
    planes = tile.counts if tile.counts is not None else tile.floats
    assert planes is not None
    return [zlib.crc32(np.ascontiguousarray(plane).tobytes()) for plane in planes]


class FrameVectors(unittest.TestCase):
    def test_every_frame(self) -> None:
        names = sorted(VECTORS.glob("*.bin"))
        self.assertGreaterEqual(len(names), 8)
        for name in names:
            with self.subTest(name.name):
                self.compare(Decoder(0).decode(name.read_bytes()), read_json(name.stem + ".json"))

    def compare(self, tile: Tile, said: dict[str, Any]) -> None:
        header, told = tile.header, said["header"]
        for field in ("n", "level_n", "tile_x", "tile_z", "channels", "depth", "layout", "flags"):
            self.assertEqual(getattr(header, field), told[field], field)
        for field in ("tick", "epoch", "sequence"):
            self.assertEqual(str(getattr(header, field)), told[field], field)
        for field in ("step", "max_error"):
            self.assertEqual([*getattr(header, field), *[0.0] * (3 - header.channels)], told[field], field)
        self.assertEqual((header.unit.cascade, header.unit.level), (told["cascade"], told["level"]))
        assert tile.counts is not None
        self.assertEqual(len(said["planes"]), header.channels)
        for plane, counts, crc in zip(said["planes"], tile.counts, crcs(tile), strict=True):
            if "counts" in plane:
                self.assertEqual(counts.ravel().tolist(), plane["counts"])
            else:
                self.assertEqual(crc, plane["crc32"])

    def test_every_stream_in_the_order_in_which_it_is_sent(self) -> None:
        names = sorted((VECTORS / "streams").glob("*.frames"))
        self.assertGreaterEqual(len(names), 9)
        for name in names:
            decoder = Decoder(1 << 20)
            said = read_json(f"streams/{name.stem}.json")["frames"]
            frames = split_stream(name.read_bytes())
            self.assertEqual(len(frames), len(said), name.name)
            for i, (frame, told) in enumerate(zip(frames, said, strict=True)):
                with self.subTest(name.name, frame=i):
                    tile = decoder.decode(frame)
                    found = {
                        "tick": str(tile.header.tick),
                        "depth": tile.header.depth,
                        "flags": tile.header.flags,
                        "bytes": len(frame),
                        "crc32": crcs(tile),
                    }
                    self.assertEqual(found, told)

    def test_every_wrong_frame_is_refused(self) -> None:
        for folder, least in (("invalid", 48), ("invalid/payloads", 20)):
            index = read_json(f"{folder}/index.json")
            self.assertEqual({v["file"] for v in index}, {f.name for f in (VECTORS / folder).glob("*.bin")})
            self.assertGreaterEqual(len(index), least)
            for vector in index:
                with self.subTest(vector["file"], why=vector["why"]), self.assertRaises(FrameError):
                    Decoder(1 << 20).decode(read_bytes(f"{folder}/{vector['file']}"))

    def test_a_refusal_names_the_field(self) -> None:
        for vector in read_json("invalid/index.json"):
            with self.subTest(vector["file"]):
                try:
                    Decoder(0).decode(read_bytes(f"invalid/{vector['file']}"))
                except FrameError as error:
                    text = str(error)
                if vector["field"] in text.split(" ")[0].split("["):
                    continue
                # Lengths and zero fields go by other names here.
                self.assertRegex(text, "^(frame is|length is|byte)")


class PointsVectors(unittest.TestCase):
    def test_every_message(self) -> None:
        names = sorted((VECTORS / "points").glob("*.bin"))
        self.assertGreaterEqual(len(names), 3)
        for name in names:
            said = read_json(f"points/{name.stem}.json")
            with self.subTest(name.name):
                points = read_points(name.read_bytes())
                for field in ("tick", "epoch", "sequence", "id"):
                    self.assertEqual(str(getattr(points, field)), said[field])
                there = [points.normal is not None, points.velocity is not None, points.jacobian is not None]
                self.assertEqual(there, [said["flags"] >> bit & 1 == 1 for bit in range(3)])
                self.assertEqual(points.folded.tolist(), [p["folded"] for p in said["points"]])
                for field in ("height", "normal", "velocity", "jacobian", "residual"):
                    values = getattr(points, field)
                    if values is not None:
                        self.assertEqual(values.tolist(), [p[field] for p in said["points"]], field)

    def test_every_cut_and_every_flipped_bit_is_refused(self) -> None:
        whole = read_bytes("points/three.bin")
        for size in range(len(whole)):
            with self.assertRaises(FrameError):
                read_points(whole[:size])
        for bit in range(len(whole) * 8):
            wrong = bytearray(whole)
            wrong[bit >> 3] ^= 1 << (bit & 7)
            with self.assertRaises(FrameError):
                read_points(bytes(wrong))


class MessageVectors(unittest.TestCase):
    def test_every_message_of_the_server(self) -> None:
        read = 0
        for vector in read_json("messages.json"):
            if vector["from"] != "server":
                continue
            with self.subTest(vector["about"]):
                message = parse_server_message(vector["text"])
                self.assertEqual(message is None, bool(vector.get("ignore")))
                read += 1
        self.assertGreaterEqual(read, 18)

    def test_what_no_client_may_send_is_nothing_that_a_server_says(self) -> None:
        """These texts are wrong for a server; a client that gets them back must refuse or ignore each."""
        vectors = read_json("invalid/messages.json")
        self.assertGreaterEqual(len(vectors), 80)
        for vector in vectors:
            with self.subTest(vector["why"], text=vector["text"][:80]):
                try:
                    self.assertIsNone(parse_server_message(vector["text"]))
                except MessageError as error:
                    self.assertLess(len(str(error)), 300)
                    continue
                # What is ignored is JSON with a type that this client doesn't read.
                self.assertIn(json.loads(vector["text"])["type"], ("subscribe", "points", "report", "Time", "time ", ""))


class ClockVectors(unittest.TestCase):
    def test_every_sequence(self) -> None:
        sequences = read_json("clock.json")
        self.assertGreaterEqual(len(sequences), 9)
        for sequence in sequences:
            clock, taken = Clock(), 0
            for query in sequence["queries"]:
                while taken < query["after"]:
                    clock.observe(Exchange(*sequence["exchanges"][taken]))
                    taken += 1
                with self.subTest(sequence["name"], at=query["at"]):
                    server, bound = clock.server_us(query["at"]), clock.error_bound_us(query["at"])
                    if query["server_us"] is None:
                        self.assertEqual((server, bound), (None, None))
                        continue
                    assert server is not None and bound is not None
                    self.assertLessEqual(abs(server - query["server_us"]), 1)
                    self.assertLessEqual(abs(bound - query["error_bound_us"]), 1)
            self.assertEqual(taken, len(sequence["exchanges"]))


if __name__ == "__main__":
    unittest.main()
