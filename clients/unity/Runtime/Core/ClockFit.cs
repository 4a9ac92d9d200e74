// What a set of time exchanges says of the server's clock: offset and rate, and how far that can be off.
//
// An exchange bounds the offset from both sides, whatever the network did: it is at most t1 - t0 (the request took no
// negative time) and at least t2 - t3. Delay only ever loosens these bounds, so the tight ones are the good samples:
// the line below every upper bound and the line above every lower bound enclose the truth (Moon, Skelly & Towsley
// 1999), and their middle is right by as much as the quickest requests and the quickest answers take equally long.
using System;

namespace Swellcast
{
    internal sealed class ClockFit
    {
        /// <summary>No two clocks differ more in rate: twice what a poor crystal is off.</summary>
        public const double MaxDrift = 200e-6;
        /// <summary>What two clocks usually differ: a slope is trusted as far as its noise is below this.</summary>
        private const double UsualDrift = 50e-6;
        /// <summary>Noise of a slope, times the span of the samples, as a share of half the least round trip.</summary>
        private const double SlopeNoise = 0.1;
        private const int Most = 128;

        private readonly long[] t0 = new long[Most], t1 = new long[Most], t2 = new long[Most], t3 = new long[Most];
        private int count;
        // Bounds of the offset, from above and from below (mirrored), relative to the origin.
        private readonly double[] upperX = new double[Most], upperY = new double[Most];
        private readonly double[] lowerX = new double[Most], lowerY = new double[Most];
        private readonly double[] sortedX = new double[Most], sortedY = new double[Most];
        private readonly int[] hull = new int[Most];

        /// <summary>
        /// Own time and offset at the newest exchange; all else is relative to it, so that it stays exact.
        /// </summary>
        public long OriginOurs, OriginOffset;
        public double Offset, Drift, Bound;

        public void Clear()
        {
            count = 0;
        }

        public void Add(long t0, long t1, long t2, long t3)
        {
            if (count == Most) DropOldest();
            this.t0[count] = t0;
            this.t1[count] = t1;
            this.t2[count] = t2;
            this.t3[count] = t3;
            count++;
            OriginOurs = t3;
            OriginOffset = t2 - t3;
        }

        /// <summary>The offset at own time, relative to the origin's.</summary>
        public double At(long ours)
        {
            return Offset + Drift * (ours - OriginOurs);
        }

        /// <summary>Fits all exchanges, but for the oldest where they exclude the newer ones.</summary>
        public void Find()
        {
            // Bounds that exclude one another: the clocks ran apart, or one was moved a little. The newer ones are right.
            while (!FindAll() && count > 1) DropOldest();
        }

        private void DropOldest()
        {
            count--;
            foreach (long[] times in new[] { t0, t1, t2, t3 }) Array.Copy(times, 1, times, 0, count);
        }

        private bool FindAll()
        {
            for (int i = 0; i < count; i++)
            {
                upperX[i] = t0[i] - OriginOurs;
                upperY[i] = t1[i] - t0[i] - OriginOffset;
                lowerX[i] = t3[i] - OriginOurs;
                lowerY[i] = -(double)(t2[i] - t3[i] - OriginOffset);
            }
            double steepest = (SupportingSlope(upperX, upperY) - SupportingSlope(lowerX, lowerY)) / 2;
            // Jitter tilts the lines, the more the shorter they are: weigh the slope by what it is worth.
            double middle, halfWidth;
            Within(steepest, out middle, out halfWidth);
            double noise = SlopeNoise * Math.Max(0, halfWidth) / Math.Max(1, upperX[count - 1] - upperX[0]);
            double share = noise / UsualDrift, drift = steepest / (1 + share * share);
            Drift = Math.Min(MaxDrift, Math.Max(-MaxDrift, drift));
            Within(Drift, out middle, out halfWidth);
            Offset = middle;
            Bound = BoundOf(middle);
            return halfWidth >= 0;
        }

        /// <summary>Where lines of a slope that touch the bounds pass the origin.</summary>
        private void Within(double drift, out double middle, out double halfWidth)
        {
            double above = double.PositiveInfinity, below = double.PositiveInfinity;
            for (int i = 0; i < count; i++)
            {
                above = Math.Min(above, upperY[i] - drift * upperX[i]);
                below = Math.Min(below, lowerY[i] + drift * lowerX[i]);
            }
            middle = (above - below) / 2;
            halfWidth = (above + below) / 2;
        }

        /// <summary>How far an offset can be off at the origin, whatever the clocks' rates.</summary>
        private double BoundOf(double offset)
        {
            double above = double.PositiveInfinity, below = double.PositiveInfinity;
            for (int i = 0; i < count; i++)
            {
                above = Math.Min(above, upperY[i] + MaxDrift * Math.Abs(upperX[i]));
                below = Math.Min(below, lowerY[i] + MaxDrift * Math.Abs(lowerX[i]));
            }
            return Math.Max(0, Math.Max(above - offset, offset + below));
        }

        /// <summary>
        /// Slope of the highest line below all points, measured at their mean: an edge of the lower convex hull.
        /// </summary>
        private double SupportingSlope(double[] x, double[] y)
        {
            Sort(x, y);
            int corners = 0;
            double sum = 0;
            for (int i = 0; i < count; i++)
            {
                while (corners >= 2 && Turn(hull[corners - 2], hull[corners - 1], i) <= 0) corners--;
                hull[corners++] = i;
                sum += x[i];
            }
            double mean = sum / count;
            for (int i = 1; i < corners; i++)
            {
                int a = hull[i - 1], b = hull[i];
                if (sortedX[b] >= mean && sortedX[b] > sortedX[a])
                {
                    return (sortedY[b] - sortedY[a]) / (sortedX[b] - sortedX[a]);
                }
            }
            return 0;
        }

        /// <summary>By x, then y: nearly in order already, since exchanges follow one another.</summary>
        private void Sort(double[] x, double[] y)
        {
            for (int i = 0; i < count; i++)
            {
                int place = i;
                for (; place > 0; place--)
                {
                    double beforeX = sortedX[place - 1], beforeY = sortedY[place - 1];
                    if (beforeX < x[i] || (beforeX == x[i] && beforeY <= y[i])) break;
                    sortedX[place] = beforeX;
                    sortedY[place] = beforeY;
                }
                sortedX[place] = x[i];
                sortedY[place] = y[i];
            }
        }

        /// <summary>Above 0 where the way from a over b to c turns upwards.</summary>
        private double Turn(int a, int b, int c)
        {
            return (sortedX[b] - sortedX[a]) * (sortedY[c] - sortedY[a])
                - (sortedY[b] - sortedY[a]) * (sortedX[c] - sortedX[a]);
        }
    }
}
