// What a row of counts is predicted to be (PROTOCOL.md section 10), in units of 2^-12 counts. Sums and products of
// 32-bit integers wrap, as C# does where nothing says `checked`.
namespace Swellcast
{
    /// <summary>The planes that one channel is predicted from: each lies in an array, all at the same offset.</summary>
    public struct Basis
    {
        /// <summary>
        /// The frames before, the newest first, or those on both sides; null where it reaches no further.
        /// </summary>
        public short[] A, B, C;
        /// <summary>Where the channel's plane begins in each.</summary>
        public int Offset;
    }

    public static class Predict
    {
        public const int Taps = 8;

        /// <summary>Row `z` of a plane of depth 1 to 3.</summary>
        public static void Past(short[] taps, ref Basis basis, int n, int z, int[] row)
        {
            int w0 = taps[0], w1 = taps[1], w2 = taps[2], w3 = taps[3], w4 = taps[4], w7 = taps[7];
            short[] a = basis.A;
            int begin = basis.Offset + z * n, last = n - 1;
            int up = basis.Offset + (z + last & last) * n, down = basis.Offset + (z + 1 & last) * n;
            int west = a[begin + last], here = a[begin];
            for (int x = 0; x < n; x++)
            {
                int east = a[begin + (x + 1 & last)];
                row[x] = w0 * here + w1 * west + w2 * east + w3 * a[up + x] + w4 * a[down + x] + (w7 * here >> 4);
                west = here;
                here = east;
            }
            if (basis.B != null) Add(taps[5], basis.B, begin, n, row);
            if (basis.C != null) Add(taps[6], basis.C, begin, n, row);
        }

        private static void Add(int tap, short[] plane, int begin, int n, int[] row)
        {
            for (int x = 0; x < n; x++) row[x] += tap * plane[begin + x];
        }

        /// <summary>Row `z` of a plane between two others.</summary>
        public static void Between(short[] taps, ref Basis basis, int n, int z, int[] row)
        {
            int w0 = taps[0], w1 = taps[1], w2 = taps[2], w3 = taps[3], w4 = taps[4], w7 = taps[7];
            short[] a = basis.A, b = basis.B;
            int begin = basis.Offset + z * n, last = n - 1;
            int up = basis.Offset + (z + last & last) * n, down = basis.Offset + (z + 1 & last) * n;
            int west = a[begin + last] + b[begin + last], hereA = a[begin], hereB = b[begin];
            for (int x = 0; x < n; x++)
            {
                int next = begin + (x + 1 & last), eastA = a[next], eastB = b[next];
                row[x] = w0 * (hereA + hereB) + w1 * west + w2 * (eastA + eastB) + w3 * (a[up + x] + b[up + x])
                    + w4 * (a[down + x] + b[down + x]) + (w7 * hereA >> 4) + (w7 * hereB >> 4);
                west = hereA + hereB;
                hereA = eastA;
                hereB = eastB;
            }
        }

        /// <summary>
        /// What the rows above say of row `z` of the plane itself, without what its own row adds: all of it for the
        /// first column, nothing in the first row.
        /// </summary>
        public static void Above(short[] taps, short[] counts, int offset, int n, int z, int[] row)
        {
            if (z == 0)
            {
                for (int x = 0; x < n; x++) row[x] = 0;
                return;
            }
            int w1 = taps[1], w2 = taps[2], w3 = taps[3], w5 = taps[5], last = n - 1;
            int up = offset + (z - 1) * n, far = z > 1 ? up - n : up;
            int northWest = counts[up], north = counts[up + 1];
            row[0] = northWest << 12;
            for (int x = 1; x < n; x++)
            {
                int northEast = x < last ? counts[up + x + 1] : north;
                row[x] = w1 * north + w2 * northWest + w3 * northEast + w5 * counts[far + x];
                northWest = north;
                north = northEast;
            }
        }
    }
}
