// The shared clock: the vectors that every client is held to, and its laws on simulated time.
using System;
using System.Collections.Generic;

namespace Swellcast.Tests
{
    internal static class ClockTests
    {
        public static void Add(Tests tests)
        {
            tests.Add("vectors: clock", ClockVectors);
            tests.Add("clock: nothing before the first exchange", Nothing);
            tests.Add("clock: jitter of 10 ms, within 3 ms and the bound", Jitter);
            tests.Add("clock: a small change is slewed, a large one followed", Changes);
            tests.Add("clock: ticks keep a fraction", Fractions);
        }

        private static void ClockVectors()
        {
            List<JsonValue> sequences = Vectors.Json("clock.json").Items;
            Check.That(sequences.Count > 0, "there are sequences");
            foreach (JsonValue sequence in sequences)
            {
                var clock = new Clock();
                int taken = 0;
                List<JsonValue> exchanges = sequence["exchanges"].Items;
                foreach (JsonValue query in sequence["queries"].Items)
                {
                    for (; taken < query["after"].Number; taken++)
                    {
                        List<JsonValue> t = exchanges[taken].Items;
                        clock.Observe((long)t[0].Number, (long)t[1].Number, (long)t[2].Number, (long)t[3].Number);
                    }
                    var at = (long)query["at"].Number;
                    string where = sequence["name"].Text + ", at " + at;
                    if (query["server_us"].Kind == JsonKind.Null)
                    {
                        Check.That(!clock.Synced, where);
                        continue;
                    }
                    Check.Near(clock.ServerUs(at), query["server_us"].Number, 1, where);
                    Check.Near(clock.ErrorBoundUs(at), query["error_bound_us"].Number, 1, where + ", bound");
                }
                Check.Same(taken, exchanges.Count, sequence["name"].Text + ": exchanges");
            }
        }

        private static void Nothing()
        {
            var clock = new Clock();
            Check.That(!clock.Synced && double.IsNaN(clock.Ticks(5)) && double.IsInfinity(clock.ErrorBoundUs(5)), "no time");
            Check.That(!clock.Observe(0, 0, 0, -1) && !clock.Observe(0, 10, 5, 20) && !clock.Observe(0, 0, 100, 50), "impossible");
            Check.That(!clock.Observe(0, 1L << 61, 1L << 61, 1) && !clock.Synced, "no one's time");
        }

        /// <summary>Runs exchanges as a session does; gives own time at the end.</summary>
        private static long Run(Clock clock, int seconds, long from, Func<long> delay, Func<long, long> server)
        {
            long now = from, end = from;
            for (int i = 0; now < from + seconds * 1000000L; i++)
            {
                long there = delay(), t1 = server(now + there);
                end = now + there + 50 + delay();
                clock.Observe(now, t1, t1 + 50, end);
                now += i < 20 ? 100000 : 1000000;
            }
            return end;
        }

        private static void Jitter()
        {
            for (int seed = 1; seed <= 20; seed++)
            {
                var random = new Random(seed);
                var clock = new Clock();
                Func<long, long> server = t => t + (long)(t * 3e-5) + 500000000000;
                long end = Run(clock, 30, 0, () => 10000 + random.Next(20000), server);
                double error = Math.Abs(clock.ServerUs(end) - server(end));
                Check.That(error <= 4000, "error " + error + " of seed " + seed);
                Check.That(error <= clock.ErrorBoundUs(end), "within the bound");
            }
        }

        private static void Changes()
        {
            long shift = 0;
            var clock = new Clock();
            Func<long, long> server = t => t + 1000000000 + shift;
            long end = Run(clock, 10, 0, () => 500, server);
            shift = -60000;
            end = Run(clock, 3, end, () => 500, server);
            long last = clock.ServerUs(end);
            for (long now = end + 16000; now < end + 10000000; now += 16000)
            {
                long shown = clock.ServerUs(now);
                Check.Near((shown - last) / 16000.0, 1, 0.011, "rate");
                last = shown;
            }
            Check.Near(clock.ServerUs(end + 10000000), server(end + 10000000), 100, "after 10 s");
            shift = 5000000;
            end = Run(clock, 1, end + 10000000, () => 500, server);
            Check.Near(clock.ServerUs(end), server(end), 1000, "after a step");
        }

        private static void Fractions()
        {
            var clock = new Clock();
            long week = 7L * 86400 * 1000000;
            clock.Observe(0, week, week, 0);
            Check.Same(clock.Ticks(0), 7 * 86400 * 7200.0, "a week");
            Check.Near(clock.Ticks(125) - clock.Ticks(0), 0.9, 1e-6, "0.9 ticks");
        }
    }
}
