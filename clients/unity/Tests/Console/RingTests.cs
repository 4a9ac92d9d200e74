// The ring of frames: exact on cubics, fewer points at edges, holding when starved.
using System;
using System.Collections.Generic;

namespace Swellcast.Tests
{
    internal static class RingTests
    {
        private const int Interval = 480;

        public static void Add(Tests tests)
        {
            tests.Add("ring: exact on a cubic, in any order of arrival", Cubics);
            tests.Add("ring: fewer points at the edges, never beyond them", Edges);
            tests.Add("ring: skipped ticks, and long gaps", Gaps);
            tests.Add("ring: what is dropped, and tiles", Dropped);
            tests.Add("ring: layers come late, and are never missed", Layers);
        }

        private static double Cubic(double t)
        {
            double a = t / 700, b = t / 900;
            return 3 + t / 500 - a * a + b * b * b;
        }

        /// <summary>A ring whose frames hold one number each.</summary>
        private sealed class Numbers
        {
            public readonly Ring Ring;
            public readonly Pick Pick = new Pick();
            private readonly double[] values;

            public Numbers(int interval, int tiles = 1)
            {
                Ring = new Ring(interval, 1680, tiles);
                values = new double[Ring.Slots];
            }

            public bool Put(long tick, double value)
            {
                int slot = Ring.Place(tick);
                if (slot >= 0) values[slot] = value;
                return slot >= 0;
            }

            public double At(double tick)
            {
                Ring.Choose(tick, Pick);
                double sum = 0;
                for (int i = 0; i < Pick.Points; i++) sum += Pick.Weights[i] * values[Pick.Slots[i]];
                return sum;
            }
        }

        private static Numbers Of(params int[] frames)
        {
            var numbers = new Numbers(Interval);
            foreach (int k in frames) Check.That(numbers.Put(k * Interval, Cubic(k * Interval)), "frame " + k + " is kept");
            return numbers;
        }

        private static void Cubics()
        {
            Numbers numbers = Of(10, 11, 12, 13, 14, 15), mixed = Of(14, 11, 13, 10, 12);
            for (double t = 11 * Interval; t <= 14 * Interval; t += 37)
            {
                Check.Near(numbers.At(t), Cubic(t), 1e-9, "value");
                Check.Same(numbers.Pick.Footing, Footing.Between, "footing");
            }
            Check.Same(numbers.Pick.Points, 4, "points");
            numbers.At(12 * Interval);
            Check.Same(numbers.Pick.Points, 1, "points on a frame");
            Check.Near(mixed.At(12.3 * Interval), Cubic(12.3 * Interval), 1e-9, "in any order");
        }

        private static void Edges()
        {
            Numbers numbers = Of(10, 11, 12, 13);
            numbers.At(10.5 * Interval);
            Check.Same(numbers.Pick.Points, 3, "points");
            numbers.At(12.5 * Interval);
            Check.Same(numbers.Pick.Points, 3, "points");
            Check.Near(numbers.At(13 * Interval), Cubic(13 * Interval), 0, "the last frame");
            Check.Same(numbers.Pick.Footing, Footing.Between, "the last frame itself is no starvation");
            Check.Near(numbers.At(15.7 * Interval), Cubic(13 * Interval), 0, "held");
            Check.Same(numbers.Pick.Footing, Footing.Starved, "footing");
            Check.Near(numbers.At(9.9 * Interval), Cubic(10 * Interval), 0, "held before the first");
            Check.Same(numbers.Pick.Footing, Footing.Starved, "footing");
            var none = new Numbers(Interval);
            none.At(100);
            Check.Same(none.Pick.Footing, Footing.Nothing, "footing of nothing");
            Check.Same(none.Ring.Reaches(100), false, "reaches");
        }

        private static void Gaps()
        {
            Numbers skipped = Of(10, 11, 13, 14);
            Check.Near(skipped.At(12.2 * Interval), Cubic(12.2 * Interval), 1e-9, "bridged by the frames about it");
            var gap = new Numbers(Interval);
            foreach (int k in new[] { 10, 11, 16, 17 }) gap.Put(k * Interval, k < 12 ? 0 : 5);
            Check.Near(gap.At(13.5 * Interval), 2.5, 1e-12, "a straight line, not a swing");
        }

        private static void Dropped()
        {
            var numbers = new Numbers(Interval);
            Check.That(!numbers.Put(Interval + 1, 0), "off the grid");
            Check.That(numbers.Put(30 * Interval, 0) && !numbers.Put(30 * Interval, 0), "a duplicate");
            int slots = numbers.Ring.Slots;
            Check.That(!numbers.Put((30 - slots) * Interval, 0), "older than what its slot holds");
            Check.That(numbers.Put((30 + slots) * Interval, 0), "newer");
            var tiled = new Numbers(Interval, 4);
            for (int i = 0; i < 3; i++) tiled.Put(10 * Interval, 1);
            tiled.At(10 * Interval);
            Check.Same(tiled.Pick.Points, 0, "three tiles of four");
            tiled.Put(10 * Interval, 1);
            Check.Near(tiled.At(10 * Interval), 1, 0, "all of them");
            Check.Same(tiled.Ring.Newest, 10 * Interval, "newest");
            Check.Same(new Ring(1, 72000, 1).Slots, 64, "slots have a bound");
        }

        private static void Layers()
        {
            int[] leads = { 1680, 1200, 1080 };
            for (int layers = 1; layers <= 3; layers++)
            {
                var numbers = new Numbers(120);
                for (int now = 0; now < 20000; now += 40)
                {
                    for (int layer = 0; layer < layers; layer++)
                    {
                        int tick = now + leads[layer];
                        if (tick % 120 != 0 || Wire.LayerOf(tick) != layer) continue;
                        Check.That(numbers.Put(tick, Cubic(tick)), "frame " + tick + " is kept");
                    }
                    if (now < 3000) continue;
                    Check.Near(numbers.At(now + 7), Cubic(now + 7), 1e-6, layers + " layers at " + now);
                    Check.Same(numbers.Pick.Points, 4, "points");
                }
            }
        }
    }
}
