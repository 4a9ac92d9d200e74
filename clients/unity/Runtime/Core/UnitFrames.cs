// The frames of one unit at one level: a ring of them, as counts of the whole patch, and their blend at a moment.
using System;

namespace Swellcast
{
    public sealed class UnitFrames
    {
        /// <summary>Samples a side of the whole patch at this level.</summary>
        public readonly int Size;
        public readonly int Channels, Level;
        public readonly Ring Ring;
        public readonly Pick Pick = new Pick();
        private readonly short[][] counts; // by slot, allocated when first needed: channels, then rows of the patch
        private readonly float[][] steps;
        private readonly float[] factors; // by channel, then frame chosen: its weight, times its step

        public UnitFrames(int channels, int size, int level, int interval, long leadTicks)
        {
            Channels = channels;
            Size = size;
            Level = level;
            int across = Math.Max(1, size / Wire.Tile);
            Ring = new Ring(interval, leadTicks, across * across);
            counts = new short[Ring.Slots][];
            steps = new float[Ring.Slots][];
            factors = new float[channels * 4];
        }

        /// <summary>Samples that the ring has room for: its memory is two bytes each.</summary>
        public static long Room(int channels, int size, int interval, long leadTicks)
        {
            return (long)channels * size * size * Ring.SlotsFor(interval, leadTicks);
        }

        /// <summary>Takes a copy of a frame of counts.</summary>
        /// <returns>Whether it was of use.</returns>
        public bool Accept(FrameHeader header, short[] frame)
        {
            if (header.LevelN != Size || header.Channels != Channels || header.N != Math.Min(Size, Wire.Tile)) return false;
            int slot = Ring.Place(header.Tick);
            if (slot < 0) return false;
            if (counts[slot] == null)
            {
                counts[slot] = new short[Channels * Size * Size];
                steps[slot] = new float[Channels];
            }
            int n = header.N;
            for (int c = 0; c < Channels; c++)
            {
                steps[slot][c] = header.Step[c];
                int from = c * n * n, to = (c * Size + header.TileZ * n) * Size + header.TileX * n;
                for (int z = 0; z < n; z++, from += n, to += Size) Array.Copy(frame, from, counts[slot], to, n);
            }
            return true;
        }

        /// <summary>Chooses the frames for a moment.</summary>
        public void Seek(double tick)
        {
            Ring.Choose(tick, Pick);
            for (int i = 0; i < factors.Length; i++)
            {
                int frame = i % 4;
                factors[i] = frame < Pick.Points ? (float)Pick.Weights[frame] * steps[Pick.Slots[frame]][i / 4] : 0;
            }
        }

        /// <summary>Writes one channel at the moment that was sought: sample i to place i * stride + first.</summary>
        public void Blend(int channel, float[] into, int stride, int first)
        {
            int samples = Size * Size, plane = channel * samples;
            int at = channel * 4;
            float f0 = factors[at], f1 = factors[at + 1], f2 = factors[at + 2], f3 = factors[at + 3];
            short[] a = Slot(0), b = Slot(1), c = Slot(2), d = Slot(3);
            for (int i = plane, to = first; i < plane + samples; i++, to += stride)
            {
                into[to] = f0 * a[i] + f1 * b[i] + f2 * c[i] + f3 * d[i];
            }
        }

        /// <summary>
        /// One channel at an undisplaced place, in patches from the origin: linear between the four samples about it.
        /// </summary>
        public float Value(int channel, double u, double v)
        {
            int x0, x1, z0, z1;
            float fx = Between(u, Size, out x0, out x1), fz = Between(v, Size, out z0, out z1);
            float sum = 0;
            for (int i = 0; i < Pick.Points; i++)
            {
                short[] plane = Slot(i);
                int north = (channel * Size + z0) * Size, south = (channel * Size + z1) * Size;
                float near = plane[north + x0] * (1 - fx) + plane[north + x1] * fx;
                float far = plane[south + x0] * (1 - fx) + plane[south + x1] * fx;
                sum += factors[channel * 4 + i] * (near * (1 - fz) + far * fz);
            }
            return sum;
        }

        /// <summary>The samples on both sides of a place, and how far it is on the way from one to the other.</summary>
        internal static float Between(double patches, int size, out int before, out int after)
        {
            double at = (patches - Math.Floor(patches)) * size;
            before = (int)at;
            if (!(at >= 0 && before < size)) at = before = 0; // rounded up to a whole patch, or no number
            after = before + 1 == size ? 0 : before + 1;
            return (float)(at - before);
        }

        /// <summary>The counts of a frame that was chosen; those that are not used weigh nothing.</summary>
        private short[] Slot(int i)
        {
            return counts[Pick.Slots[i < Pick.Points ? i : 0]];
        }
    }
}
