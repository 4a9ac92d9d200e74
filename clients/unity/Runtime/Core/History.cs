// The counts of a tile at its recent ticks: what its later frames are predicted from, the same at both ends.
//
// Invariant: three frames of layer 0 at most, and the newest of layer 1. Their memory is used again and again, so what
// is kept is a copy.
using System;

namespace Swellcast
{
    internal sealed class History
    {
        private sealed class Kept
        {
            public long Tick;
            public short[] Counts;
        }

        public readonly int Cascade, Level, Class, Group, Codec;
        public readonly ulong Epoch;
        public readonly int Samples;
        private readonly Kept[] past = new Kept[FrameHeader.MaxDepth]; // the newest first
        private int held;
        private Kept middle;
        private readonly Kept[] spare = new Kept[FrameHeader.MaxDepth + 1];
        private int spares;

        public History(FrameHeader header)
        {
            Cascade = header.Cascade;
            Level = header.Level;
            Class = header.Class;
            Group = header.Group;
            Codec = header.Codec;
            Epoch = header.Epoch;
            Samples = header.Samples;
        }

        /// <summary>
        /// Fills in what a frame of a depth above 0 is predicted from; false where something is not held.
        /// </summary>
        public bool Find(long tick, int depth, ref Basis basis)
        {
            basis.B = basis.C = null;
            if (depth == FrameHeader.Between)
            {
                int gap = Wire.LayerOf(tick) == 1 ? 240 : 120;
                return At(tick - gap, out basis.A) && At(tick + gap, out basis.B);
            }
            return At(tick - Wire.SlowestInterval, out basis.A)
                && (depth < 2 || At(tick - 2 * Wire.SlowestInterval, out basis.B))
                && (depth < 3 || At(tick - 3 * Wire.SlowestInterval, out basis.C));
        }

        /// <summary>Keeps a frame, where others may be predicted from it.</summary>
        public void Keep(long tick, short[] counts)
        {
            int layer = Wire.LayerOf(tick);
            if (layer == 0)
            {
                // A frame again, or one of another past: what is newer has nothing to do with it.
                while (held > 0 && past[0].Tick >= tick) Free(0);
                if (held == past.Length) Free(held - 1);
                Array.Copy(past, 0, past, 1, held);
                past[0] = Copy(tick, counts);
                held++;
            }
            else if (layer == 1)
            {
                if (middle != null) spare[spares++] = middle;
                middle = Copy(tick, counts);
            }
        }

        private void Free(int place)
        {
            spare[spares++] = past[place];
            held--;
            Array.Copy(past, place + 1, past, place, held - place);
        }

        private Kept Copy(long tick, short[] counts)
        {
            Kept kept = spares > 0 ? spare[--spares] : new Kept { Counts = new short[Samples] };
            kept.Tick = tick;
            Array.Copy(counts, kept.Counts, Samples);
            return kept;
        }

        private bool At(long tick, out short[] counts)
        {
            for (int i = 0; i < held; i++)
            {
                if (past[i].Tick != tick) continue;
                counts = past[i].Counts;
                return true;
            }
            bool isMiddle = middle != null && middle.Tick == tick;
            counts = isMiddle ? middle.Counts : null;
            return isMiddle;
        }
    }
}
