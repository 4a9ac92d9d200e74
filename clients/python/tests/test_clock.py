"""The laws of the shared clock, on simulated time."""

from __future__ import annotations

import random
import unittest
from collections.abc import Callable

from swellcast.clock import Clock, Exchange

Server = Callable[[int], int]


def run(clock: Clock, seconds: float, delay: Callable[[], int], server: Server, begin: int = 0) -> int:
    """Exchanges as the link makes them: 20 quick ones, then one a second. Gives when the last one ended."""
    now, i = begin, 0
    while now < begin + seconds * 1e6:
        t1 = server(now + delay())
        t3 = max(now, 0) + delay() + delay() + 50
        # The way there is over before the answer comes.
        t1 = min(t1, server(t3 - 50))
        clock.observe(Exchange(now, t1, t1 + 50, t3))
        now += 100_000 if i < 20 else 1_000_000
        i += 1
    return now


class Laws(unittest.TestCase):
    def test_nothing_before_the_first_exchange(self) -> None:
        clock = Clock()
        self.assertFalse(clock.synced)
        self.assertIsNone(clock.server_us(5))
        self.assertIsNone(clock.error_bound_us(5))
        self.assertNotEqual(clock.now(), clock.now())

    def test_on_a_quiet_network_it_is_within_its_bound_and_a_millisecond(self) -> None:
        chance, clock = random.Random(1), Clock()
        end = run(clock, 30, lambda: chance.randrange(200, 600), lambda t: t + 10**12)
        error = abs((clock.server_us(end) or 0) - (end + 10**12))
        self.assertLess(error, 1000)
        self.assertLessEqual(error, clock.error_bound_us(end) or 0)

    def test_a_small_change_is_bent_to_by_one_percent_and_never_backwards(self) -> None:
        clock, shift = Clock(), 0

        def server(t: int) -> int:
            return t + 10**9 + shift

        end = run(clock, 10, lambda: 500, server)
        shift = -60_000
        end = run(clock, 3, lambda: 500, server, end)
        last = clock.server_us(end) or 0
        for now in range(end + 16_000, end + 10_000_000, 16_000):
            shown = clock.server_us(now) or 0
            self.assertTrue(0.989 < (shown - last) / 16_000 < 1.011)
            last = shown
        self.assertLess(abs((clock.server_us(end + 10_000_000) or 0) - server(end + 10_000_000)), 1000)

    def test_a_large_change_is_a_step_and_one_wild_answer_is_none(self) -> None:
        clock, shift = Clock(), 0

        def server(t: int) -> int:
            return t + 10**9 + shift

        end = run(clock, 10, lambda: 1000, server)
        wild = server(end) + 3_600_000_000
        clock.observe(Exchange(end, wild, wild, end + 2000))
        self.assertLess(abs((clock.server_us(end) or 0) - server(end)), 2000)
        shift = 5_000_000
        end = run(clock, 1, lambda: 1000, server, end)
        self.assertLess(abs((clock.server_us(end) or 0) - server(end)), 2000)

    def test_impossible_exchanges_change_nothing(self) -> None:
        clock = Clock()
        for times in ((0, 0, 0, -1), (0, 10, 5, 20), (0, 0, 100, 50), (0, 2**61, 2**61, 1)):
            self.assertFalse(clock.observe(Exchange(*times)))
        self.assertFalse(clock.synced)


if __name__ == "__main__":
    unittest.main()
