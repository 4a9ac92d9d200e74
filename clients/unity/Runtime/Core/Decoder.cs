// Frames back to counts (PROTOCOL.md sections 5 and 10), in the order in which they came.
//
// Invariant: a frame that is wrong in any way is refused as a whole, and what was decoded before stands. Memory is
// bounded: four frames of a tile are kept for predictions, of `MostSamples` samples in all; beside that one frame. Once
// each tile has had its frames, nothing is allocated.
using System;
using System.Collections.Generic;

namespace Swellcast
{
    /// <summary>A frame as it was decoded. It belongs to the decoder and is good until the next one.</summary>
    public sealed class Frame
    {
        public readonly FrameHeader Header = new FrameHeader();
        /// <summary>All planes, one after the other, with codecs of counts; the array may be longer.</summary>
        public short[] Counts = new short[0];
        /// <summary>The same with codecs of floats.</summary>
        public float[] Floats = new float[0];

        public bool IsCounts { get { return Codec.IsCounts(Header.Codec); } }
    }

    /// <summary>Whether frames of a unit are still wanted.</summary>
    public delegate bool UnitFilter(int cascade, int level, int kind, int group, int codec);

    public sealed class Decoder
    {
        private const int TapsBytes = 2 * Predict.Taps + 4;

        /// <summary>Most samples of one moment that are kept for predictions, all units together.</summary>
        public long MostSamples;
        /// <summary>The sea that is followed: frames of another are ignored. null: of any.</summary>
        public ulong? Epoch;
        private readonly Frame frame = new Frame();
        private readonly Dictionary<long, History> tiles = new Dictionary<long, History>();
        private readonly List<long> unwanted = new List<long>();
        private readonly Rans rans = new Rans();
        private readonly Residual residual = new Residual();
        private readonly short[][] taps = { new short[Predict.Taps], new short[Predict.Taps], new short[Predict.Taps] };
        private readonly bool[] wide = new bool[Wire.MaxChannels];
        private long keptSamples;

        public Decoder(long mostSamples)
        {
            MostSamples = mostSamples;
        }

        /// <summary>Forgets all frames.</summary>
        public void Clear()
        {
            tiles.Clear();
            keptSamples = 0;
        }

        /// <summary>Forgets the frames of units that are not wanted any more.</summary>
        public void Retain(UnitFilter wanted)
        {
            unwanted.Clear();
            foreach (KeyValuePair<long, History> tile in tiles)
            {
                History h = tile.Value;
                if (!wanted(h.Cascade, h.Level, h.Class, h.Group, h.Codec)) unwanted.Add(tile.Key);
            }
            foreach (long key in unwanted) Forget(key);
        }

        /// <summary>Reads one whole binary message.</summary>
        /// <returns>null for a frame of another sea.</returns>
        /// <exception cref="FrameException">The message must be dropped.</exception>
        public Frame Decode(byte[] bytes, int offset, int length)
        {
            FrameHeader header = frame.Header;
            header.Read(bytes, offset, length);
            if (Epoch != null && Epoch.Value != header.Epoch) return null;
            int start = offset + Wire.HeaderBytes, end = offset + length, samples = header.Samples;
            if (header.Codec >= Codec.F16)
            {
                ReadFloats(bytes, start, samples, header.Codec == Codec.F16);
                return frame;
            }
            if (frame.Counts.Length < samples) frame.Counts = new short[samples];
            if (header.Codec == Codec.I16)
            {
                Wire.CopyU16(bytes, start, frame.Counts, samples);
                return frame;
            }
            long key = KeyOf(header);
            History history = Held(header, key);
            var basis = new Basis();
            if (header.Depth > 0 && (history == null || !history.Find(header.Tick, header.Depth, ref basis)))
            {
                string why = "is " + header.Depth + " at tick " + header.Tick + ", and a frame before is not held";
                throw new FrameException(Fault.Missing, "depth", why);
            }
            if (header.Codec == Codec.Rans) ReadRans(bytes, start, end, ref basis);
            else ReadDeflate(bytes, start, end, ref basis);
            if (Wire.LayerOf(header.Tick) < 2) Keep(header, key, history);
            return frame;
        }

        private void ReadFloats(byte[] bytes, int start, int samples, bool half)
        {
            if (frame.Floats.Length < samples) frame.Floats = new float[samples];
            for (int i = 0; i < samples; i++)
            {
                float value = half ? Half(Wire.U16(bytes, start + 2 * i)) : BitConverter.ToSingle(bytes, start + 4 * i);
                if (!Wire.IsFinite(value)) throw FrameException.Payload("has sample " + i + ", which is not finite");
                frame.Floats[i] = value;
            }
        }

        /// <summary>A 16-bit float.</summary>
        private static float Half(int bits)
        {
            int exponent = bits >> 10 & 31, fraction = bits & 1023;
            float sign = (bits & 0x8000) != 0 ? -1 : 1;
            if (exponent == 31) return fraction == 0 ? sign * float.PositiveInfinity : float.NaN;
            // Powers of two, and products with them, are exact.
            return exponent == 0 ? sign * fraction * (1f / (1 << 24))
                : sign * (1024 + fraction) * (exponent >= 25 ? 1 << exponent - 25 : 1f / (1 << 25 - exponent));
        }

        private void ReadRans(byte[] bytes, int start, int end, ref Basis basis)
        {
            FrameHeader header = frame.Header;
            int n = header.N, at = start;
            for (int c = 0; c < header.Channels; c++)
            {
                if (ReadTaps(bytes, at, end, taps[c])) throw FrameException.Payload("has wide 1, must be 0 with rans");
                basis.Offset = c * n * n;
                at += TapsBytes;
                at = rans.ReadPlane(bytes, at, end, header.Depth, ref basis, taps[c], n, frame.Counts, basis.Offset);
            }
            if (at != end) throw FrameException.Payload("has " + (end - at) + " bytes after the last plane");
        }

        private void ReadDeflate(byte[] bytes, int start, int end, ref Basis basis)
        {
            FrameHeader header = frame.Header;
            int n = header.N, at = start, planes = 0;
            for (int c = 0; c < header.Channels; c++, at += TapsBytes)
            {
                wide[c] = ReadTaps(bytes, at, end, taps[c]);
                planes += wide[c] ? 2 : 1;
                foreach (short tap in taps[c])
                {
                    if (header.Depth == 0 && tap != 0) throw FrameException.Payload("has tap " + tap + ", must be 0");
                }
            }
            residual.Begin(bytes, at, end, planes * n * n);
            for (int c = 0; c < header.Channels; c++)
            {
                basis.Offset = c * n * n;
                residual.Restore(wide[c], header.Depth, ref basis, taps[c], n, frame.Counts, basis.Offset);
            }
        }

        /// <summary>Fills in taps; returns whether residuals have two bytes.</summary>
        private static bool ReadTaps(byte[] bytes, int at, int end, short[] into)
        {
            if (end - at < TapsBytes) throw FrameException.Payload("is too short for taps");
            for (int i = 0; i < into.Length; i++) into[i] = (short)Wire.I16(bytes, at + 2 * i);
            uint isWide = Wire.U32(bytes, at + 2 * into.Length);
            if (isWide > 1) throw FrameException.Payload("has wide " + isWide + ", must be 0 or 1");
            return isWide == 1;
        }

        /// <summary>Unit and tile as one number.</summary>
        private static long KeyOf(FrameHeader h)
        {
            long unit = (((h.Cascade * 256L + h.Level) * 4 + h.Class) * 16 + h.Group) * 8 + h.Codec;
            return (unit * 65536 + h.TileX) * 65536 + h.TileZ;
        }

        /// <summary>What is held of the frame's tile, if it is of the same sea and size.</summary>
        private History Held(FrameHeader header, long key)
        {
            History history;
            if (!tiles.TryGetValue(key, out history)) return null;
            return history.Epoch == header.Epoch && history.Samples == header.Samples ? history : null;
        }

        private void Keep(FrameHeader header, long key, History history)
        {
            if (history == null)
            {
                Forget(key);
                // More than was asked for: what comes of it can't be predicted from.
                if (keptSamples + header.Samples > MostSamples) return;
                history = new History(header);
                tiles.Add(key, history);
                keptSamples += history.Samples;
            }
            history.Keep(header.Tick, frame.Counts);
        }

        private void Forget(long key)
        {
            History history;
            if (!tiles.TryGetValue(key, out history)) return;
            keptSamples -= history.Samples;
            tiles.Remove(key);
        }
    }
}
