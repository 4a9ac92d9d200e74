"""The water between frames: exact on cubics, fewer points at the edges, held when starved, nothing outside its ticks."""

from __future__ import annotations

import unittest

import numpy as np

from swellcast.frame import Frame
from swellcast.messages import Cascade, Hello, Layout, Limits
from swellcast.playback import RING, Playback, lagrange
from swellcast.vocabulary import TICKS_PER_SECOND, Unit

KEY = (1, "height")


def hello_of(*cascades: Cascade, epoch: int = 7) -> Hello:
    """A sea of these cascades."""
    limits = Limits(4096, 64, 64, 0)
    return Hello("s", "calm", epoch, 1, 0, 1680, 0, Layout(1, cascades), 1.0, (15,), (), (), 720, limits)


def cascade_of(index: int = 1, from_tick: int = 0, until_tick: int | None = None, n: int = 8) -> Cascade:
    """A small cascade."""
    return Cascade(index, 64.0, n, 2, 1.0, 64.0, from_tick, until_tick, ())


def frame_of(tick: int, value: float, level: int = 0, n: int = 8) -> Frame:
    """A frame of one value."""
    unit = Unit(1, level, "1mm", "height", "f32")
    planes = np.full((1, n, n), value, np.float32)
    return Frame(unit, tick, 7, 0, 1, False, False, (1.0,), (0.0,), None, planes)


def cubic(tick: float) -> float:
    """A height that no frame rate can hide."""
    return 3 + tick / 500 - (tick / 700) ** 2 + (tick / 900) ** 3


class Playing(unittest.TestCase):
    def setUp(self) -> None:
        self.playback = Playback()
        self.playback.begin(hello_of(cascade_of()), same_sea=False)

    def put(self, *places: int) -> None:
        for k in places:
            self.playback.add(frame_of(480 * k, cubic(480 * k)))

    def at(self, tick: float) -> tuple[float, bool]:
        sample = self.playback.sample(tick / TICKS_PER_SECOND)[KEY]
        return float(sample["height"][0, 0]), sample.starved

    def test_weights_add_up_to_one(self) -> None:
        for nodes in ([0.5], [-1.0, 2.0], [-700.0, -220.0, 260.0], [-700.0, -220.0, 260.0, 900.0]):
            self.assertAlmostEqual(sum(lagrange(nodes)), 1)

    def test_four_frames_in_any_order_are_exact_on_a_cubic(self) -> None:
        self.put(14, 11, 13, 10, 12)
        for tick in range(11 * 480, 13 * 480, 37):
            value, starved = self.at(tick)
            self.assertAlmostEqual(value, cubic(tick), 4)
            self.assertFalse(starved)

    def test_at_the_edges_fewer(self) -> None:
        self.playback.add(frame_of(4800, 1))
        self.playback.add(frame_of(5280, 3))
        self.assertAlmostEqual(self.at(4920)[0], 1.5, 6)

    def test_outside_the_nearest_frame_is_held_and_said_to_be_starved(self) -> None:
        self.put(10, 11, 12)
        self.assertEqual(self.at(12 * 480), (np.float32(cubic(5760)), False))
        self.assertEqual(self.at(15.7 * 480), (np.float32(cubic(5760)), True))
        self.assertEqual(self.at(9.9 * 480), (np.float32(cubic(4800)), True))

    def test_a_skipped_tick_is_bridged_and_a_long_gap_is_a_straight_line(self) -> None:
        self.put(10, 11, 13, 14)
        self.assertAlmostEqual(self.at(12.2 * 480)[0], cubic(12.2 * 480), 4)
        for k, value in ((30, 0), (31, 0), (36, 5), (37, 5)):
            self.playback.add(frame_of(480 * k, value))
        self.assertAlmostEqual(self.at(33.5 * 480)[0], 2.5, 6)

    def test_bounded(self) -> None:
        self.put(*range(100))
        self.assertEqual(len(self.playback.ticks(*KEY)), RING)

    def test_nothing_before_a_cascade_begins_nor_after_it_ends(self) -> None:
        life = hello_of(cascade_of(from_tick=4800, until_tick=9600))
        self.playback.begin(life, same_sea=True)
        for k in range(10, 20):
            self.playback.add(frame_of(480 * k, 0.0))
        self.assertEqual(self.playback.sample(4799 / 7200), {})
        self.assertEqual(self.playback.sample(9600 / 7200), {})
        # Past its last frame, which is zero, nothing is missing.
        self.assertEqual(self.at(9590), (0.0, False))

    def test_a_further_hello_keeps_what_goes_on_another_sea_nothing(self) -> None:
        self.put(1, 2)
        self.playback.begin(hello_of(cascade_of(until_tick=9600), cascade_of(8, 4800)), same_sea=True)
        self.assertEqual(self.playback.ticks(*KEY), [480, 960])
        self.playback.begin(hello_of(cascade_of(from_tick=480)), same_sea=True)
        self.assertEqual(self.playback.ticks(*KEY), [])
        self.put(1, 2)
        self.playback.begin(hello_of(cascade_of(), epoch=8), same_sea=False)
        self.assertEqual(self.playback.ticks(*KEY), [])

    def test_a_coarser_level_takes_over_once_it_reaches_back(self) -> None:
        self.put(10, 11)
        for k in range(12, 16):
            self.playback.add(frame_of(480 * k, cubic(480 * k), level=1, n=4))
        self.assertEqual(self.playback.sample(10.5 * 480 / 7200)[KEY].planes.shape, (1, 8, 8))
        self.assertEqual(self.playback.sample(12.5 * 480 / 7200)[KEY].planes.shape, (1, 4, 4))


if __name__ == "__main__":
    unittest.main()
