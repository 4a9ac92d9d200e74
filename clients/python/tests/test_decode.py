"""Headers and payloads: each way of being wrong is refused, and nothing that is sealed well crashes a decoder."""

from __future__ import annotations

import random
import struct
import unittest

import numpy as np
from support import CHANNELS, VECTORS, make_frame, patched, sealed, split_stream

from swellcast.decode import Decoder
from swellcast.errors import FrameError, MissingError
from swellcast.header import LONGEST_FRAME
from swellcast.history import History
from swellcast.predict import predict_in_time
from swellcast.vocabulary import layer_of


class Headers(unittest.TestCase):
    def test_a_valid_frame_of_each_group(self) -> None:
        for group, channels in enumerate(CHANNELS):
            tile = Decoder(0).decode(make_frame(group=group, n=16, tick=2**53 - 1, flags=3))
            assert tile.counts is not None
            self.assertEqual(tile.counts.shape, (channels, 16, 16))
            self.assertEqual(tile.counts[-1, -1, -1], (channels * 256 - 1) * 7919 % 65536 - 32768)
            self.assertEqual(tile.header.tick, 2**53 - 1)

    def test_every_cut_a_byte_too_many_and_flipped_bits(self) -> None:
        whole = make_frame()
        for size in (*range(90), len(whole) - 1):
            with self.assertRaises(FrameError):
                Decoder(0).decode(whole[:size])
        with self.assertRaises(FrameError):
            Decoder(0).decode(sealed(whole + b"\0"))
        for bit in range(0, len(whole) * 8, 3):
            wrong = bytearray(whole)
            wrong[bit >> 3] ^= 1 << (bit & 7)
            with self.assertRaises(FrameError):
                Decoder(0).decode(bytes(wrong))

    def test_each_wrong_field(self) -> None:
        nan, infinite = struct.pack("<f", float("nan")), struct.pack("<f", float("inf"))
        for at, value in (
            (0, b"s"), (4, b"\x60"), (8, b"\4"), (9, b"\x09"), (10, b"\5"), (11, b"\5"), (12, b"\0"), (12, b"\x0c"),
            (12, b"\0\2"), (14, b"\0"), (14, b"\x0c"), (14, b"\x10"), (16, b"\1"), (18, b"\1"), (20, b"\2"), (22, b"\1"),
            (23, b"\1"), (24, struct.pack("<Q", 2**53)), (52, b"\x82\1"), (56, bytes(4)), (60, struct.pack("<f", -1.0)),
            (64, infinite), (68, nan), (84, b"\1"),
        ):  # fmt: skip
            with self.subTest(at=at, value=value), self.assertRaises(FrameError):
                Decoder(0).decode(patched(make_frame(), at, value))

    def test_depth_fits_flags_codec_and_layer(self) -> None:
        payload = bytes([255]) * 60  # no plane: what passes the header fails there
        for tick, depth, flags, holds in (
            (960, 0, 0, True), (960, 3, 0, True), (960, 4, 0, False), (240, 4, 0, True), (120, 4, 0, True),
            (240, 1, 0, False), (100, 4, 0, False), (100, 0, 0, True), (960, 1, 1, False), (960, 5, 0, False),
        ):  # fmt: skip
            frame = make_frame(codec=1, payload=payload, tick=tick, depth=depth, flags=flags)
            with self.subTest(tick=tick, depth=depth), self.assertRaises(FrameError) as refused:
                Decoder(0).decode(frame)
            self.assertEqual(not str(refused.exception).startswith("depth"), holds)
        self.assertEqual([layer_of(t) for t in (0, 480, 240, 720, 120, 360, 60)], [0, 0, 1, 1, 2, 2, 3])

    def test_lengths_of_payloads(self) -> None:
        for codec, fits in ((0, (128,)), (1, (1, 64 * 4 + 8192)), (2, (1, 64 * 4 + 8192)), (3, (128,)), (4, (256,))):
            for length in (*fits, fits[0] - 1, fits[-1] + 1):
                with self.subTest(codec=codec, length=length):
                    try:
                        Decoder(0).decode(make_frame(group=3, codec=codec, payload=bytes(length)))
                        refused = ""
                    except FrameError as error:
                        refused = str(error)
                    self.assertEqual(refused.startswith("payload_bytes"), length not in fits)

    def test_the_longest_frame_is_as_long_as_is_said(self) -> None:
        self.assertEqual(LONGEST_FRAME, 88 + 3 * 65536 * 4 + 8192)


class Payloads(unittest.TestCase):
    def test_damaged_streams_give_frames_or_refusals(self) -> None:
        """Random damage under a checksum that fits: refused or decoded, never anything else."""
        damage = random.Random(7)
        refused = 0
        for name in sorted((VECTORS / "streams").glob("*.frames")):
            frames = split_stream(name.read_bytes())
            for _ in range(40):
                decoder = Decoder(1 << 20)
                for frame in frames[:4]:
                    wrong = bytearray(frame)
                    for _ in range(damage.choice((0, 1, 1, 4))):
                        wrong[damage.randrange(88, len(wrong))] = damage.randrange(256)
                    try:
                        decoder.decode(sealed(wrong))
                    except FrameError:
                        refused += 1
        self.assertGreater(refused, 500)

    def test_a_bomb_of_deflate_is_not_inflated(self) -> None:
        import zlib

        deflater = zlib.compressobj(9, zlib.DEFLATED, -15)
        bomb = deflater.compress(bytes(8 << 20)) + deflater.flush()
        with self.assertRaisesRegex(FrameError, "residuals"):
            Decoder(0).decode(make_frame(group=3, codec=2, payload=bytes(20) + bomb[:8000]))


class Bounds(unittest.TestCase):
    def test_history_holds_three_frames_and_one_between(self) -> None:
        history = History()
        for k in range(20):
            history.keep(480 * k, np.full((1, 8, 8), k, np.int16))
        history.keep(480 * 18 + 240, np.full((1, 8, 8), 99, np.int16))
        basis = history.basis(480 * 20, 3)
        assert basis is not None
        self.assertEqual([int(counts[0, 0, 0]) for counts in basis], [19, 18, 17])
        self.assertIsNone(history.basis(480 * 17, 1))
        between = history.basis(480 * 18 + 120, 4)
        assert between is not None
        self.assertEqual([int(counts[0, 0, 0]) for counts in between], [18, 99])
        # A frame of another past: what is newer has nothing to do with it.
        history.keep(480 * 18, np.zeros((1, 8, 8), np.int16))
        self.assertIsNone(history.basis(480 * 20, 1))

    def test_what_was_not_asked_for_is_not_kept(self) -> None:
        frames = split_stream((VECTORS / "streams" / "rans-16.frames").read_bytes())
        decoder = Decoder(1)
        decoder.decode(frames[0])
        with self.assertRaises(MissingError):
            decoder.decode(frames[1])

    def test_units_that_are_not_wanted_are_forgotten(self) -> None:
        frames = split_stream((VECTORS / "streams" / "rans-16.frames").read_bytes())
        decoder = Decoder(1 << 20)
        decoder.decode(frames[0])
        decoder.retain(lambda unit: False)
        with self.assertRaises(MissingError):
            decoder.decode(frames[1])


class Predictions(unittest.TestCase):
    def test_against_the_formula_sample_by_sample(self) -> None:
        """Largest counts and taps, so that sums wrap at 32 bits."""
        chance = np.random.default_rng(3)
        n = 8
        planes = [chance.integers(-32768, 32768, (n, n)).astype(np.int16) for _ in range(3)]
        taps = tuple(int(tap) for tap in chance.choice([-32768, 32767, 12345, -1], 8))

        def wrapped(value: int) -> int:
            return (value + 2**31) % 2**32 - 2**31

        for depth in (1, 2, 3, 4):
            used = planes[: 2 if depth == 4 else depth]
            predicted = predict_in_time(depth, used, taps)
            frames = [np.asarray(plane, object) for plane in used]
            for z in range(n):
                for x in range(n):
                    around = ((z, x), (z, (x - 1) % n), (z, (x + 1) % n), ((z - 1) % n, x), ((z + 1) % n, x))
                    crossed = frames if depth == 4 else frames[:1]
                    sum = 0
                    for plane in crossed:
                        sum += wrapped(int(plane[z, x]) * taps[7]) >> 4
                        for tap, place in zip(taps, around, strict=False):
                            sum += tap * int(plane[place])
                    if depth < 4:
                        for tap, plane in zip(taps[5:7], frames[1:], strict=False):
                            sum += tap * int(plane[z, x])
                    self.assertEqual(int(predicted[z, x]), wrapped(sum))


if __name__ == "__main__":
    unittest.main()
