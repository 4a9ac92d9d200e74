// Prints what a stream says, tick by tick, so that clients can be compared: subscribes to the displacement of cascade 0
// at 15 Hz, class 5mm, codec rans, and gives the CRC-32 of its counts, of the whole patch, channels in order.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.IO;
using System.Threading;

namespace Swellcast.Tests
{
    internal static class Program
    {
        private static int Main(string[] args)
        {
            string url = null;
            double seconds = 10;
            for (int i = 0; i + 1 < args.Length; i += 2)
            {
                if (args[i] == "--url") url = args[i + 1];
                else if (args[i] != "--seconds" || !Seconds(args[i + 1], out seconds)) url = null;
            }
            if (url == null || args.Length % 2 != 0)
            {
                Console.Error.WriteLine("usage: mono Digest.exe --url URL [--seconds S]");
                return 2;
            }
            var digests = new Digests();
            var wish = new Wish { Class = "5mm", RateHz = 15, Cascades = new[] { 0 }, Reports = false };
            try
            {
                using (new Connection(url, wish, digests)) Thread.Sleep((int)(seconds * 1000));
            }
            catch (ArgumentException error)
            {
                Console.Error.WriteLine(error.Message);
                return 2;
            }
            if (digests.Lines > 0) return 0;
            Console.Error.WriteLine("no frame came within " + seconds + " s");
            return 1;
        }

        private static bool Seconds(string text, out double seconds)
        {
            bool good = double.TryParse(text, NumberStyles.Float, CultureInfo.InvariantCulture, out seconds);
            return good && seconds > 0 && seconds < 1e6;
        }
    }

    /// <summary>Puts tiles of a tick together, and prints the tick once all are there.</summary>
    internal sealed class Digests : Listener
    {
        private sealed class Patch
        {
            public short[] Counts;
            public int Tiles;
        }

        private const int MostTicks = 4; // under way at a time
        private readonly SortedDictionary<long, Patch> patches = new SortedDictionary<long, Patch>();
        private int level;

        public int Lines { get; private set; }

        public override void OnHello(Hello hello, Plan plan, bool same)
        {
            if (plan.Units.Count == 0) Console.Error.WriteLine("the server has no displacement of cascade 0");
            else level = plan.Units[0].Level;
        }

        public override void OnState(bool connected, string why)
        {
            if (!connected) Console.Error.WriteLine("not connected: " + why);
        }

        public override void OnRefused(string why)
        {
            Console.Error.WriteLine("refused: " + why);
        }

        public override void OnFailed(Exception error)
        {
            if (error is IOException) Environment.Exit(1); // nobody reads any more
            Console.Error.WriteLine(error);
        }

        public override void OnFrame(Frame frame)
        {
            FrameHeader h = frame.Header;
            if (h.Level != level) return; // coarser than asked for, since the server is short of something
            int across = h.LevelN / h.N;
            if (across == 1)
            {
                Print(h.Tick, Crc32.OfCounts(0, frame.Counts, 0, h.Samples));
                return;
            }
            Patch patch;
            if (!patches.TryGetValue(h.Tick, out patch))
            {
                if (patches.Count == MostTicks) patches.Remove(Oldest());
                patch = new Patch { Counts = new short[h.Channels * h.LevelN * h.LevelN] };
                patches.Add(h.Tick, patch);
            }
            for (int row = 0; row < h.Channels * h.N; row++)
            {
                int channel = row / h.N, z = h.TileZ * h.N + row % h.N;
                Array.Copy(frame.Counts, row * h.N, patch.Counts, (channel * h.LevelN + z) * h.LevelN + h.TileX * h.N, h.N);
            }
            if (++patch.Tiles < across * across) return;
            patches.Remove(h.Tick);
            Print(h.Tick, Crc32.OfCounts(0, patch.Counts, 0, patch.Counts.Length));
        }

        private long Oldest()
        {
            foreach (long tick in patches.Keys) return tick;
            return 0;
        }

        private void Print(long tick, uint digest)
        {
            Console.Out.WriteLine("{\"tick\":" + tick + ",\"digest\":\"" + digest.ToString("x8") + "\"}");
            Console.Out.Flush();
            Lines++;
        }
    }
}
