// What a decoder keeps, and for how long; that damage changes nothing; that nothing is allocated for each frame.
using System;
using System.Collections.Generic;

namespace Swellcast.Tests
{
    internal static class DecoderTests
    {
        public static void Add(Tests tests)
        {
            tests.Add("crc: the standard check string, and every short length", Crc);
            tests.Add("decoder: references that are missing are said to be", Missing);
            tests.Add("decoder: another epoch or unit has nothing to do with it", Others);
            tests.Add("decoder: a frame that is damaged changes nothing", Damage);
            tests.Add("decoder: memory is bounded", Bounded);
            tests.Add("decoder: nothing is allocated in steady state", Allocations);
            tests.Add("decoder: halves", Halves);
        }

        private static List<byte[]> Stream(string name)
        {
            return Vectors.Split(Vectors.Bytes("streams/" + name + ".frames"));
        }

        private static uint Decode(Decoder decoder, byte[] frame)
        {
            Frame decoded = decoder.Decode(frame, 0, frame.Length);
            return Crc32.OfCounts(0, decoded.Counts, 0, decoded.Header.Samples);
        }

        private static void Crc()
        {
            byte[] check = System.Text.Encoding.ASCII.GetBytes("123456789");
            Check.Same(Crc32.Of(0, check, 0, 9), 0xcbf43926u, "crc");
            for (int length = 0; length < 40; length++)
            {
                var bytes = new byte[length + 88];
                for (int i = 0; i < bytes.Length; i++) bytes[i] = (byte)(i * 37);
                Samples.Seal(bytes);
                uint crc = Crc32.Of(Crc32.Of(0, bytes, 0, 80), bytes, 88, length);
                Check.Same(crc, Wire.U32(bytes, 80), "crc of " + length);
            }
        }

        private static void Missing()
        {
            List<byte[]> frames = Stream("rans-16");
            for (int left = 0; left < frames.Count; left++)
            {
                var decoder = new Decoder(1 << 16);
                var lost = new List<int>();
                for (int i = 0; i < frames.Count; i++)
                {
                    if (i == left) continue;
                    try
                    {
                        Decode(decoder, frames[i]);
                    }
                    catch (FrameException error)
                    {
                        Check.Same(error.Fault, Fault.Missing, "without frame " + left + ", frame " + i);
                        lost.Add(i);
                    }
                }
                var header = new FrameHeader();
                header.Read(frames[left], 0, frames[left].Length);
                bool needed = Wire.LayerOf(header.Tick) == 0 && left + 4 < frames.Count;
                Check.That(lost.Count > 0 || !needed, "something is missed without frame " + left);
            }
        }

        private static void Others()
        {
            List<byte[]> frames = Stream("rans-16");
            foreach (int at in new[] { 6, 7, 8, 9, 32 })
            {
                var decoder = new Decoder(1 << 16);
                Decode(decoder, frames[0]);
                var other = (byte[])frames[1].Clone();
                other[at] = at == 9 ? (byte)Group.Normals : at == 8 ? (byte)3 : (byte)(other[at] + 1);
                Samples.Seal(other);
                var error = Check.Throws<FrameException>(() => Decode(decoder, other), "byte " + at);
                Check.Same(error.Fault, Fault.Missing, "byte " + at);
                Decode(decoder, frames[1]);
            }
            var only = new Decoder(1 << 16) { Epoch = 5 };
            Check.Same(only.Decode(frames[1], 0, frames[1].Length), null, "a frame of another sea");
        }

        private static void Damage()
        {
            foreach (string name in new[] { "rans-16", "rans-64", "rans-shift", "rans-escapes", "deflate-16", "deflate-wide" })
            {
                List<byte[]> frames = Stream(name);
                var whole = new Decoder(1 << 20);
                var hurt = new Decoder(1 << 20);
                var random = new Random(7);
                foreach (byte[] frame in frames)
                {
                    for (int round = 0; round < 60; round++)
                    {
                        var damaged = (byte[])frame.Clone();
                        int flips = 1 + random.Next(3);
                        while (flips-- > 0) damaged[88 + random.Next(frame.Length - 88)] ^= (byte)(1 << random.Next(8));
                        Samples.Seal(damaged);
                        try
                        {
                            // A wrong tap or escape is another frame: only a checksum tells. It goes to one of its own.
                            new Decoder(1 << 20).Decode(damaged, 0, damaged.Length);
                        }
                        catch (FrameException)
                        {
                        }
                    }
                    for (int cut = 1; cut < 40 && cut < frame.Length - 88; cut += 3)
                    {
                        var shorter = new byte[frame.Length - cut];
                        Array.Copy(frame, shorter, shorter.Length);
                        Samples.Put(shorter, 52, shorter.Length - 88, 4);
                        Samples.Seal(shorter);
                        Check.Throws<FrameException>(() => Decode(hurt, shorter), name + " cut by " + cut);
                    }
                    Check.Same(Decode(hurt, frame), Decode(whole, frame), name);
                }
            }
        }

        private static void Bounded()
        {
            List<byte[]> frames = Stream("rans-16");
            var header = new FrameHeader();
            header.Read(frames[0], 0, frames[0].Length);
            var decoder = new Decoder(3 * header.Samples);
            Func<int, int, byte[]> of = (frame, cascade) =>
            {
                var bytes = (byte[])frames[frame].Clone();
                bytes[6] = (byte)cascade;
                Samples.Seal(bytes);
                return bytes;
            };
            for (int cascade = 0; cascade < 5; cascade++) Decode(decoder, of(0, cascade));
            for (int cascade = 0; cascade < 3; cascade++) Decode(decoder, of(1, cascade));
            Check.Throws<FrameException>(() => Decode(decoder, of(1, 3)), "the fourth");
            decoder.Retain((cascade, level, kind, group, codec) => cascade != 1);
            Check.Throws<FrameException>(() => Decode(decoder, of(1, 1)), "what was let go of");
            Decode(decoder, of(0, 4));
            Decode(decoder, of(1, 4));
        }

        private static void Allocations()
        {
            foreach (string name in new[] { "rans-16", "rans-64", "rans-shift", "rans-escapes", "deflate-wide" })
            {
                List<byte[]> frames = Stream(name);
                var decoder = new Decoder(1 << 20);
                for (int round = 0; round < 3; round++) foreach (byte[] frame in frames) decoder.Decode(frame, 0, frame.Length);
                GC.Collect();
                long before = GC.GetTotalMemory(true);
                int collections = GC.CollectionCount(0);
                const int Rounds = 300;
                for (int round = 0; round < Rounds; round++)
                {
                    foreach (byte[] frame in frames) decoder.Decode(frame, 0, frame.Length);
                }
                // The collector counts memory in blocks; a few bytes a frame would show as more than this.
                long grown = GC.GetTotalMemory(false) - before;
                Check.Same(GC.CollectionCount(0), collections, name + ": collections");
                Check.That(grown < 8 * Rounds * frames.Count, name + ": " + grown + " bytes in " + Rounds * frames.Count);
            }
        }

        private static void Halves()
        {
            int[] bits = { 0, 0x8000, 1, 0x3ff, 0x400, 0x3c00, 0xc000, 0x7bff };
            float[] must = { 0, 0, 1f / (1 << 24), 1023f / (1 << 24), 1f / (1 << 14), 1, -2, 65504 };
            var payload = new byte[128];
            for (int i = 0; i < 64; i++) Samples.Put(payload, 2 * i, bits[i % 8], 2);
            byte[] frame = Samples.Frame(Group.Foam, codec: Codec.F16, payload: payload);
            Frame decoded = new Decoder(0).Decode(frame, 0, frame.Length);
            for (int i = 0; i < 64; i++) Check.Same(decoded.Floats[i], must[i % 8], "half " + bits[i % 8]);
            foreach (int bad in new[] { 0x7c00, 0xfc00, 0xfe00 })
            {
                Samples.Put(payload, 126, bad, 2);
                byte[] wrong = Samples.Frame(Group.Foam, codec: Codec.F16, payload: payload);
                Check.Throws<FrameException>(() => new Decoder(0).Decode(wrong, 0, wrong.Length), "half " + bad);
            }
        }
    }
}
