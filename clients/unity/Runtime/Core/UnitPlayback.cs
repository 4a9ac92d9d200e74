// One unit over time: the frames of the level that is shown, and those of another level that will take over. A server
// may send a unit coarser than it was granted, and fine again; each is shown from its first frame on.
namespace Swellcast
{
    internal sealed class UnitPlayback
    {
        private readonly Cascade cascade;
        private readonly int group;
        private readonly long leadTicks;
        private UnitFrames coming;
        private bool hidden = true;

        /// <summary>The level that was granted.</summary>
        public readonly int FinestLevel;
        public readonly int Interval;
        /// <summary>Samples that it may hold, also while two levels are held.</summary>
        public readonly long Room;
        /// <summary>The level that is shown.</summary>
        public UnitFrames Current { get; private set; }

        public UnitPlayback(Cascade cascade, int group, int level, int interval, long leadTicks)
        {
            this.cascade = cascade;
            this.group = group;
            this.leadTicks = leadTicks;
            FinestLevel = level;
            Interval = interval;
            long fine = UnitFrames.Room(Names.GroupChannels[group], cascade.N >> level, interval, leadTicks);
            Room = fine + fine / 4; // a level and the next
            Current = FramesOf(level);
        }

        public bool IsFoam { get { return group == Group.Foam; } }

        /// <summary>Whether there is anything to show at the moment that was sought.</summary>
        public bool Shown { get { return !hidden && Current.Pick.Points > 0; } }

        public long Newest
        {
            get { return coming != null && coming.Ring.Newest > Current.Ring.Newest ? coming.Ring.Newest : Current.Ring.Newest; }
        }

        private UnitFrames FramesOf(int level)
        {
            return new UnitFrames(Names.GroupChannels[group], cascade.N >> level, level, Interval, leadTicks);
        }

        public bool Accept(FrameHeader header, short[] counts)
        {
            if (header.Level == Current.Level) return Current.Accept(header, counts);
            bool possible = header.Level >= FinestLevel && header.Level < cascade.Levels
                && cascade.N >> header.Level == header.LevelN;
            if (!possible) return false;
            if (coming == null || coming.Level != header.Level) coming = FramesOf(header.Level);
            return coming.Accept(header, counts);
        }

        /// <summary>Sets the moment; another level takes over once its frames reach back to it.</summary>
        public Footing Seek(double tick)
        {
            if (coming != null && (coming.Ring.Reaches(tick) || Current.Ring.Newest < 0))
            {
                Current = coming;
                coming = null;
            }
            Current.Seek(tick);
            hidden = false;
            return Current.Pick.Footing;
        }

        /// <summary>Counts as nothing, until the next moment is sought.</summary>
        public void Hide()
        {
            hidden = true;
        }

        /// <summary>Lets go of its frames: its cascade is over.</summary>
        public void Clear()
        {
            if (Newest < 0) return;
            Current = FramesOf(Current.Level);
            coming = null;
        }
    }
}
