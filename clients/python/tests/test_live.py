"""The client against a real server, named by SWELLCAST_BIN."""

from __future__ import annotations

import asyncio
import dataclasses
import json
import logging
import math
import sys
import tempfile
import time
import unittest
import zlib
from pathlib import Path

import numpy as np
from serving import BINARY, Served, skip_loudly

import swellcast
from swellcast.gather import dispersion_of, gather
from swellcast.http import ask

#: Two cascades of 64 x 64 samples: light enough for a busy machine.
SCENE = """
name = "live"
[wind]
speed_mps = 8
range_mps = [2.0, 20.0]
[cascades]
n = 64
patches_m = [400.0, 45.0]
"""


def digest(frame: swellcast.Frame) -> int:
    """CRC-32 of a frame's counts."""
    assert frame.counts is not None
    return zlib.crc32(frame.counts.astype("<i2").tobytes())


async def frames_of(ocean: swellcast.Ocean, count: int, seconds: float = 20.0) -> list[swellcast.Frame]:
    """The next frames."""
    async with asyncio.timeout(seconds):
        return [await anext(ocean) for _ in range(count)]


@unittest.skipUnless(BINARY, skip_loudly() if not BINARY else "")
class Live(unittest.IsolatedAsyncioTestCase):
    folder: tempfile.TemporaryDirectory[str]
    scene: Path
    served: Served
    skipped = 0

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = tempfile.TemporaryDirectory(prefix="swellcast-py-")
        cls.scene = Path(cls.folder.name) / "live.toml"
        cls.scene.write_text(SCENE)
        cls.served = Served(cls.scene)

    @classmethod
    def tearDownClass(cls) -> None:
        cls.served.stop()
        cls.folder.cleanup()

    def setUp(self) -> None:
        logging.getLogger("swellcast").setLevel(logging.ERROR)

    async def test_ticks_are_continuous_at_each_rate(self) -> None:
        async with swellcast.connect(self.served.url) as ocean:
            for rate in ocean.hello.rates_hz:
                for _ in range(5):
                    ticks = await self.ticks_of(ocean, rate)
                    wanted = list(range(ticks[0], ticks[-1] + 1, 7200 // rate))
                    if ticks == wanted or not await self.was_spared(ocean):
                        break
                self.assertEqual(ticks, wanted)
            self.assertEqual(ocean.dropped, 0)

    async def ticks_of(self, ocean: swellcast.Ocean, rate: int) -> list[int]:
        await ocean.subscribe("height", cascades=[0], rate_hz=rate, codec="i16")
        frames = await frames_of(ocean, 60)
        # Frames between others come later than these: those at the ends may not have come yet.
        return sorted(frame.tick for frame in frames)[8:-8]

    async def was_spared(self, ocean: swellcast.Ocean) -> bool:
        """Whether the server has skipped ticks, or sent less: a busy machine, and no fault of the client."""
        before = 0 if ocean.status is None else ocean.status.skipped_frames
        spared = ocean.quality is not None or before > self.skipped
        self.skipped = max(self.skipped, before)
        return spared

    async def test_every_codec_gives_the_counts_of_i16(self) -> None:
        groups = ["displacement", "slopes", "foam", "jacobian"]
        seen: dict[str, dict[tuple[int, swellcast.Unit], int]] = {}

        async def collect(codec: str) -> None:
            async with swellcast.connect(self.served.url, playback=False) as ocean:
                await ocean.subscribe(groups, error="5mm", codec=codec, rate_hz=60, keys=codec == "deflate")
                ends = time.monotonic() + 4
                while time.monotonic() < ends:
                    (frame,) = await frames_of(ocean, 1)
                    # Whoever falls behind on a busy machine is sent coarser levels.
                    unit = dataclasses.replace(frame.unit, codec="any")
                    seen.setdefault(codec, {})[frame.tick, unit] = digest(frame)

        await asyncio.gather(*(collect(codec) for codec in ("i16", "rans", "deflate")))
        for codec in ("rans", "deflate"):
            both = seen["i16"].keys() & seen[codec].keys()
            self.assertGreater(len(both), 100, codec)
            self.assertEqual([key for key in both if seen["i16"][key] != seen[codec][key]], [])

    async def test_floats_are_within_the_error_of_counts(self) -> None:
        async with swellcast.connect(self.served.url) as one, swellcast.connect(self.served.url) as other:
            await one.subscribe("displacement", codec="f32")
            await other.subscribe("displacement", codec="rans", error="0.5mm")
            exact = {(f.tick, f.unit.cascade): f for f in await frames_of(one, 40)}
            compared = 0
            for frame in await frames_of(other, 40):
                if (truth := exact.get((frame.tick, frame.unit.cascade))) is not None:
                    self.assertLessEqual(float(np.abs(frame.planes - truth.planes).max()), max(frame.max_error))
                    compared += 1
            self.assertGreater(compared, 10)

    async def test_a_patch_of_four_tiles_is_put_together(self) -> None:
        large = Path(self.folder.name) / "large.toml"
        large.write_text('name = "large"\n[wind]\nspeed_mps = 8\n[cascades]\nn = 512\npatches_m = [300.0]\n')
        served = await asyncio.to_thread(Served, large)
        try:
            async with swellcast.connect(served.url) as one, swellcast.connect(served.url) as other:
                await one.subscribe("height", codec="i16")
                await other.subscribe("height", codec="deflate")
                mine, theirs = await asyncio.gather(frames_of(one, 12), frames_of(other, 12))
                known = {frame.tick: digest(frame) for frame in mine}
                same = [known[frame.tick] == digest(frame) for frame in theirs if frame.tick in known]
                self.assertGreater(len(same), 4)
                self.assertTrue(all(same))
                height = theirs[-1]["height"]
                self.assertEqual(height.shape, (512, 512))
                # No seam: across the edge of two tiles heights differ as little as within one.
                steps = np.abs(np.diff(height, axis=1)).max(axis=0)
                self.assertLess(float(steps[255]), 1.5 * float(np.delete(steps, 255).max()))
                self.assertLess(float(np.abs(height[:, 0] - height[:, -1]).max()), 1.5 * float(steps.max()))
        finally:
            served.stop()

    async def test_the_clock_is_the_servers(self) -> None:
        async with swellcast.connect(self.served.url) as ocean:
            await asyncio.sleep(2.5)
            before = ocean.clock.server_us()
            told = (await ask(self.served.url, "GET", "/v1/time"))["time_us"]
            after, bound = ocean.clock.server_us(), ocean.clock.error_bound_us()
            assert before is not None and after is not None and bound is not None
            self.assertTrue(before - bound <= told <= after + bound, (before, told, after, bound))
            self.assertLess(bound, 50_000)

    async def test_playback_is_the_sea_between_its_frames(self) -> None:
        async with swellcast.connect(self.served.url) as ocean:
            await ocean.subscribe("height", codec="f32", rate_hz=30)
            await frames_of(ocean, 60)
            now = ocean.clock.now()
            sample = ocean.playback.sample(now)
            self.assertEqual(sorted(sample), [(0, "height"), (1, "height")])
            self.assertFalse(any(water.starved for water in sample.values()))
            # What the frames around say when one between them is left out.
            other = swellcast.Playback()
            other.begin(ocean.hello, same_sea=False)
            await ocean.subscribe("height", codec="f32", rate_hz=15)
            truth = {f.tick: f for f in await frames_of(ocean, 40) if f.unit.cascade == 0}
            for tick, frame in truth.items():
                if tick % 960 == 0:
                    other.add(frame)
            between = [t for t in truth if t % 960 == 480 and min(truth) + 960 < t < max(truth) - 960]
            self.assertGreater(len(between), 2)
            for tick in between:
                sample_of = other.sample_of(0, "height", tick / 7200)
                assert sample_of is not None
                error = sample_of.planes - truth[tick].planes
                self.assertLess(float(error.std()), 0.05 * float(truth[tick].planes.std()))

    async def test_probe_statistics_and_points_agree_with_the_stream(self) -> None:
        async with swellcast.connect(self.served.url) as ocean:
            statistics = await ocean.statistics()
            self.assertGreater(statistics.hs_m, 0.1)
            await ocean.follow([[3.0, 4.0], [50.0, -7.0]])
            async with asyncio.timeout(10):
                followed = await anext(ocean.points())
            probe = await ocean.probe([[3.0, 4.0], [50.0, -7.0]], tick=followed.tick)
            np.testing.assert_allclose(probe.height, followed.height, atol=2e-4)
            assert probe.normal is not None and followed.normal is not None
            np.testing.assert_allclose(probe.normal, followed.normal, atol=2e-3)
            await ocean.follow([])
            with self.assertRaises(swellcast.HttpError) as refused:
                await ocean.probe([])
            self.assertEqual((refused.exception.status, refused.exception.problem["field"]), (422, "points"))

    async def test_the_digests_of_codecs_agree(self) -> None:
        async def lines_of(codec: str) -> dict[int, str]:
            command = [sys.executable, "-m", "swellcast.digest", "--url", self.served.url, "--seconds", "3"]
            pipe = asyncio.subprocess.PIPE
            process = await asyncio.create_subprocess_exec(*command, "--codec", codec, stdout=pipe)
            output, _ = await process.communicate()
            self.assertEqual(process.returncode, 0)
            lines = [json.loads(line) for line in output.splitlines()]
            return {line["tick"]: line["digest"] for line in lines}

        rans, plain = await asyncio.gather(lines_of("rans"), lines_of("i16"))
        self.assertEqual([*rans], sorted(rans))
        both = rans.keys() & plain.keys()
        self.assertGreater(len(both), 20)
        self.assertEqual([tick for tick in both if rans[tick] != plain[tick]], [])

    async def test_the_spectrum_of_the_stream_has_the_energy_of_the_sea(self) -> None:
        async with swellcast.connect(self.served.url, playback=False) as ocean:
            found = await gather(ocean, 4.0)
            spectrum = found.spectrum(await dispersion_of(ocean))
            told = await ocean.statistics()
        self.assertLess(abs(spectrum.hs_m / told.hs_m - 1), 0.25)
        times, heights = found.series()
        self.assertGreater(len(times), 50)
        self.assertLess(float(np.abs(heights).max()), 2 * told.hs_m)

    async def test_a_change_of_wind_is_told_to_all(self) -> None:
        async with swellcast.connect(self.served.url) as ocean:
            events = ocean.events()
            accepted = await ocean.set_wind(12, 200, transition_s=1)
            async with asyncio.timeout(10):
                while not isinstance(event := await events.get(), swellcast.Change):
                    pass
            self.assertEqual((event.sequence, event.effective_tick), (accepted.sequence, accepted.effective_tick))
            self.assertEqual(event.change, swellcast.Wind(12.0, 200.0))
            with self.assertRaisesRegex(swellcast.HttpError, "speed_mps"):
                await ocean.set_wind(200, 0)

    async def test_a_change_of_layout_flows_on(self) -> None:
        served = await asyncio.to_thread(Served, self.scene)
        try:
            async with swellcast.connect(served.url) as ocean:
                await ocean.subscribe("displacement", cascades=[0], codec="rans")
                (old,) = {frame.unit.cascade for frame in await frames_of(ocean, 4)}
                body = {"n": 32, "patches_m": [100.0, 19.0], "transition_s": 1}
                await ask(served.url, "PUT", "/v1/scenes/live/layout", body)
                ticks: dict[int, list[int]] = {old: []}
                until = None
                async with asyncio.timeout(60):
                    while until is None or all(t[-1] < until for t in ticks.values() if t):
                        frame = await anext(ocean)
                        ticks.setdefault(frame.unit.cascade, []).append(frame.tick)
                        if (cascade := ocean.hello.cascade(old)) is not None:
                            until = cascade.until_tick
                self.assertEqual(len(ticks), 2)
                self.assertEqual(ticks[old][-1], until - 480)
                for of_cascade in ticks.values():
                    self.assertEqual(of_cascade, list(range(of_cascade[0], of_cascade[-1] + 1, 480)))
        finally:
            served.stop()

    async def test_a_server_that_is_killed_and_restarted_is_resumed_within_5_s_in_sync(self) -> None:
        data = Path(self.folder.name) / "data"
        first = await asyncio.to_thread(Served, self.scene, data)
        address = first.url.removeprefix("http://")
        second: Served | None = None
        try:
            async with swellcast.connect(first.url) as ocean:
                await ocean.subscribe("displacement", codec="rans")
                held = await frames_of(ocean, 30)
                epoch = ocean.hello.epoch
                first.stop()
                events = ocean.events()
                async with asyncio.timeout(10):
                    while not isinstance(await events.get(), swellcast.Disconnected):
                        pass
                second = await asyncio.to_thread(Served, self.scene, data, address)
                began = time.monotonic()
                async with asyncio.timeout(20):
                    while not isinstance(await events.get(), swellcast.Hello):
                        pass
                    while (frame := await anext(ocean)).tick <= max(f.tick for f in held) or not ocean.granted:
                        pass
                took = time.monotonic() - began
                print(f"resumed {took:.2f} s after the server was back", flush=True)
                self.assertLess(took, 5.0)
                assert second is not None
                self.assertEqual((ocean.hello.epoch, frame.epoch), (epoch, epoch))
                # In sync: another client, who joined after all that, holds the same water at the same ticks.
                async with swellcast.connect(second.url) as late:
                    await late.subscribe("displacement", codec="i16")
                    mine, theirs = await asyncio.gather(frames_of(ocean, 40), frames_of(late, 40))
                    known = {(f.tick, f.unit.cascade): digest(f) for f in mine}
                    same = [known[f.tick, f.unit.cascade] == digest(f) for f in theirs if (f.tick, f.unit.cascade) in known]
                    self.assertGreater(len(same), 10)
                    self.assertTrue(all(same))
                    await asyncio.sleep(1)
                    apart = abs(ocean.clock.now() - late.clock.now())
                    self.assertLess(apart, 0.02)
                    self.assertFalse(math.isnan(apart))
        finally:
            first.stop()
            if second is not None:
                second.stop()


if __name__ == "__main__":
    unittest.main()
