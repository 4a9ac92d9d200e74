// Which frames to show at a time, and with which weights. Knows ticks and slots, nothing of samples.
//
// Frames of a unit lie on an absolute grid of ticks, and come in any order: those of 15 Hz first, those between them
// later, or not at all where a client is given fewer. A ring holds a few of them; the four around a time, whatever lies
// between, are joined by the Lagrange cubic through them, fewer at the edges. Never beyond the last frame: it is held.
using System;

namespace Swellcast
{
    /// <summary>How well a moment stands between frames.</summary>
    public enum Footing
    {
        /// <summary>No frame is held: nothing to show.</summary>
        Nothing,
        /// <summary>The moment lies outside the frames held; the nearest is shown.</summary>
        Starved,
        /// <summary>Frames on both sides, or one at that very moment.</summary>
        Between,
    }

    /// <summary>What to show: up to four slots of the ring and their weights.</summary>
    public sealed class Pick
    {
        public readonly int[] Slots = new int[4];
        public readonly double[] Weights = new double[4];
        /// <summary>Frames used.</summary>
        public int Points;
        public Footing Footing;
    }

    public sealed class Ring
    {
        /// <summary>How far apart frames may lie and still be joined by a curve: three of the lowest rate.</summary>
        private const long MaxGap = 3 * Wire.SlowestInterval;
        private const int MostSlots = 64;

        /// <summary>Ticks between frames.</summary>
        public readonly int Interval;
        public readonly int Slots;
        private readonly int tiles;
        private readonly long[] ticks; // what a slot holds or gathers
        private readonly int[] have; // tiles there
        private readonly double[] nodes = new double[4];

        /// <summary>The newest tick of which all tiles are there, -1 before the first.</summary>
        public long Newest { get; private set; }

        /// <param name="interval">Ticks between frames.</param>
        /// <param name="leadTicks">How far ahead frames come.</param>
        /// <param name="tiles">Frames of one tick that make a whole patch.</param>
        public Ring(int interval, long leadTicks, int tiles)
        {
            Interval = interval;
            Slots = SlotsFor(interval, leadTicks);
            this.tiles = tiles;
            ticks = new long[Slots];
            have = new int[Slots];
            for (int i = 0; i < Slots; i++) ticks[i] = -1;
            Newest = -1;
        }

        /// <summary>
        /// A curve needs two frames behind now, and where fewer are given they lie as far apart as the slowest.
        /// </summary>
        public static int SlotsFor(int interval, long leadTicks)
        {
            return (int)Math.Min(MostSlots, (leadTicks + 2 * Wire.SlowestInterval) / interval + 3);
        }

        /// <summary>Where a frame belongs; the caller writes it there at once.</summary>
        /// <returns>-1 for a frame to drop: off the grid, older than what is held, or there already.</returns>
        public int Place(long tick)
        {
            if (tick % Interval != 0) return -1;
            var slot = (int)(tick / Interval % Slots);
            if (ticks[slot] > tick) return -1;
            if (ticks[slot] != tick)
            {
                ticks[slot] = tick;
                have[slot] = 0;
            }
            else if (have[slot] >= tiles)
            {
                return -1;
            }
            have[slot]++;
            if (have[slot] == tiles && tick > Newest) Newest = tick;
            return slot;
        }

        /// <summary>Chooses the frames for a moment, in ticks with a fraction.</summary>
        public void Choose(double tick, Pick pick)
        {
            // The two newest frames at or before the moment and the two oldest after it.
            int before = -1, far = -1, after = -1, beyond = -1;
            for (int s = 0; s < Slots; s++)
            {
                if (ticks[s] < 0 || have[s] < tiles) continue;
                if (ticks[s] <= tick) Nearest(s, true, ref before, ref far);
                else Nearest(s, false, ref after, ref beyond);
            }
            pick.Points = 0;
            Array.Clear(pick.Weights, 0, 4);
            Array.Clear(pick.Slots, 0, 4);
            bool exact = before >= 0 && ticks[before] == tick;
            pick.Footing = before < 0 && after < 0 ? Footing.Nothing
                : exact || (before >= 0 && after >= 0) ? Footing.Between : Footing.Starved;
            if (pick.Footing == Footing.Nothing) return;
            if (exact || pick.Footing == Footing.Starved)
            {
                Use(pick, before < 0 ? after : before);
                pick.Weights[0] = 1;
                return;
            }
            bool smooth = ticks[after] - ticks[before] <= MaxGap;
            if (smooth && far >= 0 && ticks[before] - ticks[far] <= MaxGap) Use(pick, far);
            Use(pick, before);
            Use(pick, after);
            if (smooth && beyond >= 0 && ticks[beyond] - ticks[after] <= MaxGap) Use(pick, beyond);
            Lagrange(nodes, pick.Points, tick, pick.Weights);
        }

        private void Nearest(int slot, bool newest, ref int first, ref int second)
        {
            if (first < 0 || ticks[slot] > ticks[first] == newest)
            {
                second = first;
                first = slot;
            }
            else if (second < 0 || ticks[slot] > ticks[second] == newest)
            {
                second = slot;
            }
        }

        private void Use(Pick pick, int slot)
        {
            nodes[pick.Points] = ticks[slot];
            pick.Slots[pick.Points++] = slot;
        }

        /// <summary>Whether a whole frame lies at a moment or before it.</summary>
        public bool Reaches(double tick)
        {
            for (int s = 0; s < Slots; s++)
            {
                if (ticks[s] >= 0 && ticks[s] <= tick && have[s] == tiles) return true;
            }
            return false;
        }

        /// <summary>Weights of the polynomial through `count` nodes, at `t`.</summary>
        public static void Lagrange(double[] nodes, int count, double t, double[] weights)
        {
            for (int i = 0; i < count; i++)
            {
                double weight = 1;
                for (int j = 0; j < count; j++)
                {
                    if (j != i) weight *= (t - nodes[j]) / (nodes[i] - nodes[j]);
                }
                weights[i] = weight;
            }
        }
    }
}
