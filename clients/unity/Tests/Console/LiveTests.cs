// Against a real server, named by SWELLCAST_BIN: frames without gaps, codecs that agree, a restart that is survived.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.IO;
using System.Threading;

namespace Swellcast.Tests
{
    internal static class LiveTests
    {
        public static void Add(Tests tests)
        {
            tests.Add("live: frames of every unit, in time and without gaps", Continuous);
            tests.Add("live: all codecs agree, floats within max_error", Codecs);
            tests.Add("live: heights from frames are those of points", Heights);
            tests.Add("live: a server is killed and started: back within 5 s", Restart);
        }

        private static void WithServer(Action<LocalServer, string> test)
        {
            string data = LocalServer.NewFolder();
            try
            {
                using (var server = new LocalServer(data)) test(server, data);
            }
            finally
            {
                Directory.Delete(data, true);
            }
        }

        /// <summary>Waits until something holds; false after so long.</summary>
        private static bool Until(int ms, Func<bool> holds)
        {
            Stopwatch watch = Stopwatch.StartNew();
            while (!holds())
            {
                if (watch.ElapsedMilliseconds > ms) return false;
                Thread.Sleep(5);
            }
            return true;
        }

        private sealed class Ears : Listener
        {
            public readonly List<string> Troubles = new List<string>();
            public readonly Dictionary<string, List<long>> Ticks = new Dictionary<string, List<long>>();
            public Action<Frame> Frame = frame => { };
            public Action<PointsMessage> Points = points => { };
            public Action<Hello, Plan, bool> Hello = (hello, plan, same) => { };
            public int Frames;
            /// <summary>What the server said that it skips or leaves out, being busy.</summary>
            public string Excuse;

            public override void OnHello(Hello hello, Plan plan, bool same)
            {
                Hello(hello, plan, same);
            }

            public override void OnFrame(Frame frame)
            {
                FrameHeader h = frame.Header;
                string unit = Names.Groups[h.Group] + " of " + h.Cascade;
                if (!Ticks.ContainsKey(unit)) Ticks.Add(unit, new List<long>());
                Ticks[unit].Add(h.Tick);
                Frame(frame);
                Interlocked.Increment(ref Frames);
            }

            public override void OnMessage(object message)
            {
                var status = message as Status;
                var quality = message as Quality;
                if (status != null && status.SkippedFrames > 0) Excuse = status.SkippedFrames + " frames skipped";
                if (quality != null) Excuse = quality.RateHz + " Hz, coarser by " + quality.Coarser;
            }

            public override void OnPoints(PointsMessage points)
            {
                Points(points);
            }

            public override void OnRefused(string why)
            {
                lock (Troubles) Troubles.Add(why);
            }

            public override void OnFailed(Exception error)
            {
                lock (Troubles) Troubles.Add(error.ToString());
            }

            public void NoTrouble()
            {
                lock (Troubles) Check.Same(string.Join("\n", Troubles), "", "troubles");
            }
        }

        private static void Continuous()
        {
            WithServer((server, data) =>
            {
                var ears = new Ears();
                double late = 0;
                Connection connection = null;
                ears.Frame = frame =>
                {
                    double now = connection == null ? double.NaN : connection.Ticks;
                    if (ears.Frames > 100 && now > frame.Header.Tick) late++;
                };
                var wish = new Wish { Groups = new[] { "displacement", "normals" }, RateHz = 15, Reports = false };
                using (connection = new Connection(server.Url, wish, ears)) Thread.Sleep(6000);
                ears.NoTrouble();
                Check.Same(ears.Ticks.Count, 8, "units of four cascades");
                foreach (KeyValuePair<string, List<long>> unit in ears.Ticks)
                {
                    if (ears.Excuse == null) Check.That(unit.Value.Count > 60, unit.Value.Count + " frames of " + unit.Key);
                    for (int i = 1; i < unit.Value.Count; i++)
                    {
                        long passed = unit.Value[i] - unit.Value[i - 1];
                        bool good = passed == 480 || (ears.Excuse != null && passed > 0 && passed % 480 == 0);
                        Check.That(good, unit.Key + ": " + passed + " ticks after " + unit.Value[i - 1]);
                    }
                }
                if (ears.Excuse != null) Console.WriteLine("        the server is busy: " + ears.Excuse);
                else Check.That(late <= ears.Frames / 100, late + " of " + ears.Frames + " frames came after their time");
                Check.That(connection.ErrorBoundUs < 20000, "bound of server time: " + connection.ErrorBoundUs);
            });
        }

        private static void Codecs()
        {
            WithServer((server, data) =>
            {
                string[] codecs = { "i16", "rans", "deflate", "f32" };
                var counts = new Dictionary<string, short[]>(); // by codec, level and tick
                var floats = new Dictionary<string, float[]>(); // by level and tick, as the next
                var headers = new Dictionary<string, float[]>(); // steps, then errors
                var all = new List<Ears>();
                var connections = new List<Connection>();
                foreach (string codec in codecs)
                {
                    string name = codec;
                    var ears = new Ears();
                    ears.Frame = frame =>
                    {
                        FrameHeader h = frame.Header;
                        string at = " level " + h.Level + ", tick " + h.Tick; // a busy server sends coarser levels
                        lock (counts)
                        {
                            if (!frame.IsCounts)
                            {
                                floats[at] = new float[h.Samples];
                                Array.Copy(frame.Floats, floats[at], h.Samples);
                                return;
                            }
                            counts[name + at] = new short[h.Samples];
                            Array.Copy(frame.Counts, counts[name + at], h.Samples);
                            if (name != "i16") return;
                            var said = new float[6];
                            h.Step.CopyTo(said, 0);
                            h.MaxError.CopyTo(said, 3);
                            headers[at] = said;
                        }
                    };
                    int rate = name == "rans" ? 60 : 30;
                    var wish = new Wish { Cascades = new[] { 1 }, RateHz = rate, Codec = codec, Reports = false };
                    all.Add(ears);
                    connections.Add(new Connection(server.Url, wish, ears));
                }
                Thread.Sleep(6000);
                foreach (Connection connection in connections) connection.Dispose();
                foreach (Ears ears in all) ears.NoTrouble();
                int compared = 0, sized = 0;
                foreach (KeyValuePair<string, float[]> at in headers)
                {
                    short[] must = counts["i16" + at.Key];
                    foreach (string codec in new[] { "rans", "deflate" })
                    {
                        short[] got;
                        if (!counts.TryGetValue(codec + at.Key, out got)) continue;
                        compared++;
                        for (int i = 0; i < must.Length; i++)
                        {
                            if (got[i] == must[i]) continue;
                            throw new Exception(codec + at.Key + ", sample " + i + ": " + got[i] + ", not " + must[i]);
                        }
                    }
                    float[] field;
                    if (!floats.TryGetValue(at.Key, out field)) continue;
                    sized++;
                    for (int i = 0; i < must.Length; i++)
                    {
                        int channel = i / (must.Length / 3);
                        double error = Math.Abs(must[i] * (double)at.Value[channel] - field[i]);
                        if (error <= at.Value[3 + channel] * 1.0001) continue;
                        throw new Exception("error " + error + at.Key + ", sample " + i);
                    }
                }
                bool busy = all.Exists(ears => ears.Excuse != null);
                Check.That(compared > (busy ? 20 : 200), "ticks compared: " + compared);
                Check.That(sized > (busy ? 10 : 80), "ticks beside their field: " + sized);
                Check.That(busy || all[1].Frames > 220, "frames at 60 Hz: " + all[1].Frames);
            });
        }

        private static void Heights()
        {
            WithServer((server, data) =>
            {
                double[] places = { 3.25, -7.5, 1234.5, 77.25, -500, 12000.75 };
                Sea sea = null;
                double squares = 0, heights = 0;
                int messages = 0;
                var ears = new Ears();
                ears.Hello = (hello, plan, same) => sea = new Sea(hello, plan, null);
                ears.Frame = frame => sea.Accept(frame);
                var waiting = new Queue<KeyValuePair<long, Water[]>>(); // until the frames of their tick are there
                ears.Points = points =>
                {
                    waiting.Enqueue(new KeyValuePair<long, Water[]>(points.Tick, (Water[])points.Points.Clone()));
                    if (waiting.Count < 3) return;
                    KeyValuePair<long, Water[]> at = waiting.Dequeue();
                    sea.Seek(at.Key);
                    if (sea.Footing != Footing.Between) return;
                    messages++;
                    for (int i = 0; i < points.Count; i++)
                    {
                        double height = at.Value[i].Height;
                        double error = sea.HeightAt(places[2 * i], places[2 * i + 1]) - height;
                        squares += error * error;
                        heights += height * height;
                    }
                };
                using (var connection = new Connection(server.Url, new Wish { Class = "0.5mm" }, ears))
                {
                    connection.Follow(places, 15);
                    Check.That(Until(20000, () => messages > 45), "messages of points: " + messages);
                }
                ears.NoTrouble();
                double share = Math.Sqrt(squares / heights);
                Console.WriteLine("        rms error of heights: " + (100 * share).ToString("0.0") + " % of theirs");
                Check.That(share < 0.05, "rms error as a share of the rms height: " + share);
            });
        }

        private static void Restart()
        {
            WithServer((first, data) =>
            {
                var ears = new Ears();
                bool same = false;
                long newest = 0;
                ears.Hello = (hello, plan, goesOn) => same = goesOn;
                ears.Frame = frame => newest = Math.Max(newest, frame.Header.Tick);
                using (var connection = new Connection(first.Url, new Wish(), ears))
                {
                    Check.That(Until(10000, () => ears.Frames > 60), "frames before: " + ears.Frames);
                    first.Kill();
                    Thread.Sleep(3000);
                    long before = newest;
                    int frames = ears.Frames;
                    using (new LocalServer(data, first.Port))
                    {
                        Stopwatch watch = Stopwatch.StartNew();
                        Check.That(Until(5000, () => ears.Frames > frames + 8), "frames within 5 s");
                        Console.WriteLine("        back after " + watch.ElapsedMilliseconds + " ms");
                        Check.That(same, "it is the same sea");
                        Check.That(newest > before, "later than before");
                    }
                }
                ears.NoTrouble();
            });
        }
    }
}
