// Times the decoder on frames of a live server (SWELLCAST_BIN), and the blend that a picture needs.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.IO;
using System.Threading;

namespace Swellcast.Tests
{
    internal static class DecodeBench
    {
        private const int Rounds = 12;

        private sealed class Frames : Listener
        {
            public readonly List<byte[]> Messages = new List<byte[]>();
            public Hello Hello;
            public Plan Plan;

            public override void OnHello(Hello hello, Plan plan, bool same)
            {
                Hello = hello;
                Plan = plan;
            }
        }

        /// <summary>Collects frames of all cascades at 30 Hz and 1 mm, then decodes them again and again.</summary>
        public static int Run(int seconds)
        {
            string data = LocalServer.NewFolder();
            try
            {
                var frames = new Frames();
                using (var server = new LocalServer(data)) Collect(server.Url, seconds, frames);
                Decode(frames.Messages);
                Blend(frames);
                return 0;
            }
            catch (Skipped skipped)
            {
                Console.WriteLine("SKIPPED: " + skipped.Message);
                return 0;
            }
            finally
            {
                Directory.Delete(data, true);
            }
        }

        private static void Collect(string url, int seconds, Frames frames)
        {
            var groups = new[] { "displacement", "normals", "foam" };
            var wish = new Wish { Groups = groups, RateHz = 30, Reports = false };
            var session = new Session(wish, frames, Connection.NowUs);
            using (StreamSocket socket = StreamSocket.Open(Address.Of(url)))
            {
                session.Begin(socket);
                Stopwatch watch = Stopwatch.StartNew();
                while (watch.Elapsed.TotalSeconds < seconds + 2)
                {
                    if (socket.Receive(50))
                    {
                        if (socket.IsText) session.Text(socket.Text(), Connection.NowUs());
                        else session.Binary(socket.Bytes, 0, socket.Length, Connection.NowUs());
                        if (!socket.IsText)
                        {
                            var copy = new byte[socket.Length];
                            Array.Copy(socket.Bytes, copy, copy.Length);
                            frames.Messages.Add(copy);
                        }
                    }
                    session.Beat();
                }
                socket.Close();
            }
        }

        private static void Decode(List<byte[]> messages)
        {
            var times = new SortedDictionary<string, List<double>>();
            for (int round = -1; round < Rounds; round++)
            {
                var decoder = new Decoder(1 << 25);
                foreach (byte[] message in messages)
                {
                    long began = Stopwatch.GetTimestamp();
                    FrameHeader h = decoder.Decode(message, 0, message.Length).Header;
                    double ms = (Stopwatch.GetTimestamp() - began) * 1000.0 / Stopwatch.Frequency;
                    if (round < 0) continue; // until all is compiled
                    string depth = h.Depth == 0 ? "key" : h.Depth == FrameHeader.Between ? "between" : "past";
                    string kind = Names.Groups[h.Group] + " " + h.N + " x " + h.N + " x " + h.Channels + ", " + depth;
                    if (!times.ContainsKey(kind)) times.Add(kind, new List<double>());
                    times[kind].Add(ms);
                }
            }
            Console.WriteLine("decode, ms a frame: median, 95th percentile, frames");
            foreach (KeyValuePair<string, List<double>> kind in times) Print(kind.Key, kind.Value);
        }

        private static void Blend(Frames frames)
        {
            var decoder = new Decoder(1 << 25);
            var sea = new Sea(frames.Hello, frames.Plan, null);
            long tick = 0;
            foreach (byte[] message in frames.Messages)
            {
                Frame frame = decoder.Decode(message, 0, message.Length);
                if (Wire.LayerOf(frame.Header.Tick) == 0) tick = Math.Max(tick, frame.Header.Tick);
                sea.Accept(frame);
            }
            var times = new List<double>();
            var places = new List<double>();
            var updates = new List<double>();
            var vertices = new List<double>();
            var fields = new SeaFields(sea);
            var samples = new float[256 * 256 * 4];
            for (int round = 0; round < 10 * Rounds; round++)
            {
                long began = Stopwatch.GetTimestamp();
                sea.Seek(tick - 960 + round * 3.7);
                int size = sea.SizeOf(1, Group.Displacement);
                for (int c = 0; c < 3; c++) sea.Blend(1, Group.Displacement, c, size, samples, 4, c);
                times.Add((Stopwatch.GetTimestamp() - began) * 1000.0 / Stopwatch.Frequency);
                began = Stopwatch.GetTimestamp();
                for (int i = 0; i < 100; i++) sea.HeightAt(i * 3.1, round);
                places.Add((Stopwatch.GetTimestamp() - began) * 1000.0 / Stopwatch.Frequency);
                began = Stopwatch.GetTimestamp();
                fields.Seek(tick - 960 + round * 3.7);
                updates.Add((Stopwatch.GetTimestamp() - began) * 1000.0 / Stopwatch.Frequency);
                began = Stopwatch.GetTimestamp();
                for (int i = 0; i < 65 * 65; i++) fields.At(i % 65 * 1.7, i / 65 * 1.7);
                vertices.Add((Stopwatch.GetTimestamp() - began) * 1000.0 / Stopwatch.Frequency);
            }
            Print("blend displacement of one cascade", times);
            Print("blend all fields: six channels, four cascades", updates);
            Print("a surface of 64 x 64 cells of them", vertices);
            Print("HeightAt, 100 places", places);
        }

        private static void Print(string what, List<double> times)
        {
            times.Sort();
            double median = times[times.Count / 2], late = times[times.Count * 95 / 100];
            Console.WriteLine("  {0,-50} {1,7:0.000} {2,7:0.000} {3,6}", what, median, late, times.Count);
        }
    }
}
