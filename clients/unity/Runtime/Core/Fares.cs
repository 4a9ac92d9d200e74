// How a connection fares: what it tells the server about once a second, so that it is given what it can take.
using System;

namespace Swellcast
{
    public sealed class Fares
    {
        private long last, us;
        private int ticks; // since the last report: frames of how many ticks, and what they took

        public Fares()
        {
            Reset();
        }

        /// <summary>The newest tick of a frame that was decoded, 0 before the first.</summary>
        public long Newest { get; private set; }

        /// <summary>Begins anew: another subscription.</summary>
        public void Reset()
        {
            Newest = us = ticks = 0;
            last = -1;
        }

        /// <summary>Counts a frame, and how long decoding it took.</summary>
        public void Decoded(long tick, long tookUs)
        {
            Newest = Math.Max(Newest, tick);
            if (tick != last) ticks++; // frames of one tick stand together
            last = tick;
            us += tookUs;
        }

        /// <summary>
        /// The report of the time since the one before; `nowTicks` is NaN where server time is not known.
        /// </summary>
        public string Report(double nowTicks, bool lost)
        {
            double ahead = double.IsNaN(nowTicks) ? 0 : (Newest - nowTicks) * 1000 / Wire.TicksPerSecond;
            string report = ClientMessages.Report(Newest, us / 1000.0 / Math.Max(1, ticks), ahead, lost);
            us = ticks = 0;
            return report;
        }
    }
}
