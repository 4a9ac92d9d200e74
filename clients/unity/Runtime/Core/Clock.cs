// The shared clock: server time from the four times of each exchange (PROTOCOL.md section 6), held to
// proto/vectors/clock.json. Own time is always an argument. All times are microseconds.
using System;

namespace Swellcast
{
    /// <summary>Not safe for several threads: who shares it locks.</summary>
    public sealed class Clock
    {
        /// <summary>A jump of server time larger than this is followed at once.</summary>
        private const double StepUs = 200000;
        /// <summary>Share of passing time by which server time is bent towards the truth otherwise.</summary>
        private const double Slew = 0.01;
        /// <summary>Times beyond this are nobody's: 36,000 years.</summary>
        private const long MaxUs = 1L << 60;

        private readonly ClockFit fit = new ClockFit();
        private bool fitted;
        private double lag; // what server time still lacks to the fit at its origin
        private int contradictions; // exchanges in a row that the fit says can't be

        /// <summary>Whether there is any time to show.</summary>
        public bool Synced { get { return fitted; } }

        /// <summary>By how much the server's clock runs faster than ours, as a share.</summary>
        public double Drift { get { return fitted ? fit.Drift : 0; } }

        /// <summary>Forgets everything: another timeline begins.</summary>
        public void Reset()
        {
            fit.Clear();
            fitted = false;
            lag = 0;
            contradictions = 0;
        }

        /// <summary>
        /// Takes one exchange: t0 and t3 are when we sent and received, t1 and t2 when the server did.
        /// </summary>
        /// <returns>Whether it was possible; an impossible one changes nothing.</returns>
        public bool Observe(long t0, long t1, long t2, long t3)
        {
            if (!Within(t0) || !Within(t1) || !Within(t2) || !Within(t3)) return false;
            if (t3 < t0 || t2 < t1 || t2 - t1 > t3 - t0) return false;
            bool hadTime = fitted;
            double ahead = hadTime ? Ahead(t3) : 0; // of own time
            long origin = fit.OriginOffset;
            if (hadTime && Contradicts(t0, t1, t2, t3))
            {
                // One of our clocks was set or stood still: the old samples say nothing about the new time. Two in a
                // row, so that one wild answer doesn't throw away a good fit.
                if (++contradictions < 2) return true;
                fit.Clear();
            }
            contradictions = 0;
            fit.Add(t0, t1, t2, t3);
            fit.Find();
            fitted = true;
            double now = Rounded(fit.Offset) + (double)(fit.OriginOffset - origin);
            lag = hadTime ? ahead - now : 0;
            if (Math.Abs(lag) > StepUs) lag = 0;
            return true;
        }

        /// <summary>Server time since tick 0 at own time `now`; only where `Synced`.</summary>
        public long ServerUs(long now)
        {
            return now + fit.OriginOffset + (long)Ahead(now);
        }

        /// <summary>Server time in ticks at own time `now`, with a fraction; NaN before the first exchange.</summary>
        public double Ticks(long now)
        {
            if (!fitted) return double.NaN;
            long us = ServerUs(now), seconds = us / 1000000, rest = us % 1000000;
            // 64 bits of microseconds would lose their last digits in one product: whole seconds apart.
            return seconds * (double)Wire.TicksPerSecond + rest * (Wire.TicksPerSecond / 1e6);
        }

        /// <summary>
        /// How far server time can be off: the truth lies within it even if one direction took no time and the clocks'
        /// rates differ as much as clocks may. Infinite before the first exchange.
        /// </summary>
        public double ErrorBoundUs(long now)
        {
            if (!fitted) return double.PositiveInfinity;
            double passed = Math.Max(0, now - fit.OriginOurs);
            double left = Math.Max(0, Math.Abs(lag) - Slew * passed);
            return Math.Ceiling(fit.Bound + left + ClockFit.MaxDrift * passed);
        }

        /// <summary>
        /// Server time less own time and the origin's offset: small, so that a double is exact enough.
        /// </summary>
        private double Ahead(long now)
        {
            double passed = now - fit.OriginOurs;
            double left = Math.Max(0, Math.Abs(lag) - Slew * Math.Max(0, passed));
            return Rounded(fit.Offset + fit.Drift * passed + (lag < 0 ? -left : left));
        }

        /// <summary>Whether an exchange rules out the fit by more than a step.</summary>
        private bool Contradicts(long t0, long t1, long t2, long t3)
        {
            double upper = t1 - t0 - fit.OriginOffset, lower = t2 - t3 - fit.OriginOffset;
            return fit.At(t0) > upper + StepUs || fit.At(t3) < lower - StepUs;
        }

        private static bool Within(long t)
        {
            return t >= -MaxUs && t <= MaxUs;
        }

        /// <summary>To the nearest whole number, halves away from 0.</summary>
        private static double Rounded(double x)
        {
            return Math.Round(x, MidpointRounding.AwayFromZero);
        }
    }
}
