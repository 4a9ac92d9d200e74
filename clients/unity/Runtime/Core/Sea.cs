// The sea at one moment: the frames that were received of every cascade, joined in time and summed.
//
// Each cascade counts at its own ticks alone, so that none begins or ends with a step while the layout changes. Frames
// come on the network's thread and are looked at on another: every member takes the lock.
using System;

namespace Swellcast
{
    public sealed class Sea
    {
        /// <summary>Most samples that are held, two bytes each: rings of all units together.</summary>
        private const long MostSamples = 1L << 28;
        /// <summary>Rounds of looking for the particle that is now at a place.</summary>
        private const int Rounds = 4;

        public readonly Cascade[] Cascades;
        public readonly long LeadTicks;
        /// <summary>Shared with the sea before, as are units that go on: that one may still be shown.</summary>
        private readonly object gate;
        private readonly UnitPlayback[][] units; // by place of the cascade, then group; null where none is subscribed

        /// <summary>Units that were subscribed and don't fit into what may be held.</summary>
        public readonly int LeftOut;

        /// <summary>The worst footing of any unit that should be there, at the moment that was sought.</summary>
        public Footing Footing { get; private set; }

        /// <param name="before">A sea of the same epoch: frames of cascades that go on are taken from it; or null.</param>
        public Sea(Hello hello, Plan plan, Sea before)
        {
            gate = before == null ? new object() : before.gate;
            Cascades = hello.Cascades;
            LeadTicks = hello.LeadTicks;
            units = new UnitPlayback[Cascades.Length][];
            for (int i = 0; i < units.Length; i++) units[i] = new UnitPlayback[Names.Groups.Length];
            long room = MostSamples;
            foreach (UnitName unit in plan.Units)
            {
                int place = PlaceOf(unit.Cascade), group = Names.IndexOf(Names.Groups, unit.Group);
                if (place < 0 || group < 0 || units[place][group] != null) continue;
                int interval = plan.IntervalOf(unit);
                UnitPlayback held = before == null ? null : before.Find(Cascades[place], group, unit.Level, interval);
                var playback = held ?? new UnitPlayback(Cascades[place], group, unit.Level, interval, LeadTicks);
                room -= playback.Room;
                if (room < 0)
                {
                    LeftOut++;
                    continue;
                }
                units[place][group] = playback;
            }
        }

        /// <summary>A unit of a cascade that goes on, with its frames; null where there is none that fits.</summary>
        private UnitPlayback Find(Cascade cascade, int group, int level, int interval)
        {
            int place = PlaceOf(cascade.Index);
            UnitPlayback unit = place < 0 ? null : units[place][group];
            bool fits = unit != null && unit.FinestLevel == level && unit.Interval == interval
                && Cascades[place].FromTick == cascade.FromTick && Cascades[place].N == cascade.N;
            return fits ? unit : null;
        }

        private int PlaceOf(int index)
        {
            for (int i = 0; i < Cascades.Length; i++)
            {
                if (Cascades[i].Index == index) return i;
            }
            return -1;
        }

        /// <summary>Takes a copy of a frame of counts.</summary>
        /// <returns>Whether it was of use.</returns>
        public bool Accept(Frame frame)
        {
            FrameHeader header = frame.Header;
            if (!frame.IsCounts) return false;
            lock (gate)
            {
                int place = PlaceOf(header.Cascade);
                UnitPlayback unit = place < 0 ? null : units[place][header.Group];
                return unit != null && Cascades[place].IsThere(header.Tick) && unit.Accept(header, frame.Counts);
            }
        }

        /// <summary>Sets the moment of all that is asked from then on.</summary>
        public void Seek(double tick)
        {
            lock (gate)
            {
                Footing worst = Footing.Between;
                bool any = false;
                for (int i = 0; i < Cascades.Length; i++)
                {
                    bool there = Cascades[i].IsThere(tick);
                    foreach (UnitPlayback unit in units[i])
                    {
                        if (unit == null) continue;
                        if (!there)
                        {
                            // What is over is let go of; what has not begun is kept and counts as nothing.
                            if (tick >= Cascades[i].FromTick) unit.Clear();
                            unit.Hide();
                            continue;
                        }
                        any = true;
                        Footing footing = unit.Seek(tick);
                        if (Cascades[i].Rests(tick) || unit.IsFoam) continue; // foam comes once it is warm
                        if (footing < worst) worst = footing;
                    }
                }
                Footing = any ? worst : Footing.Nothing;
            }
        }

        /// <summary>Ticks of frames held ahead of a moment by the unit that has the fewest.</summary>
        public double Ahead(double tick)
        {
            lock (gate)
            {
                double least = double.PositiveInfinity;
                for (int i = 0; i < Cascades.Length; i++)
                {
                    if (!Cascades[i].IsThere(tick) || Cascades[i].UntilTick != null) continue;
                    foreach (UnitPlayback unit in units[i])
                    {
                        if (unit != null && unit.Newest >= 0) least = Math.Min(least, unit.Newest - tick);
                    }
                }
                return double.IsPositiveInfinity(least) ? 0 : least;
            }
        }

        /// <summary>
        /// The displacement of the particle that rests at a place: metres to the east, up, to the south.
        /// </summary>
        public void Displacement(double x0, double z0, out float dx, out float height, out float dz)
        {
            lock (gate)
            {
                dx = Sum(Group.Displacement, 0, x0, z0);
                height = Sum(Group.Displacement, 1, x0, z0);
                dz = Sum(Group.Displacement, 2, x0, z0);
            }
        }

        /// <summary>
        /// The height of the water at a place of the world, of the particle that is there now; 0 where nothing is known.
        /// </summary>
        public float HeightAt(double x, double z)
        {
            lock (gate)
            {
                double x0 = x, z0 = z;
                for (int round = 0; round < Rounds; round++)
                {
                    double dx = Sum(Group.Displacement, 0, x0, z0), dz = Sum(Group.Displacement, 2, x0, z0);
                    x0 = x - dx;
                    z0 = z - dz;
                }
                return Sum(Group.Displacement, 1, x0, z0);
            }
        }

        private float Sum(int group, int channel, double x0, double z0)
        {
            float sum = 0;
            for (int i = 0; i < units.Length; i++)
            {
                UnitPlayback unit = units[i][group];
                if (unit == null || !unit.Shown) continue;
                sum += unit.Current.Value(channel, x0 / Cascades[i].PatchM, z0 / Cascades[i].PatchM);
            }
            return sum;
        }

        /// <summary>
        /// Samples a side that a unit is shown with at the moment that was sought; 0 where there is nothing to show.
        /// </summary>
        public int SizeOf(int place, int group)
        {
            lock (gate)
            {
                UnitPlayback unit = units[place][group];
                return unit != null && unit.Shown ? unit.Current.Size : 0;
            }
        }

        /// <summary>
        /// Writes the samples of a channel at the moment that was sought, row by row: sample i to i * stride + first.
        /// </summary>
        /// <returns>false where there is nothing to show, or another number of samples than `size` a side.</returns>
        public bool Blend(int place, int group, int channel, int size, float[] into, int stride, int first)
        {
            lock (gate)
            {
                UnitPlayback unit = units[place][group];
                if (unit == null || !unit.Shown || unit.Current.Size != size) return false;
                unit.Current.Blend(channel, into, stride, first);
                return true;
            }
        }
    }
}
