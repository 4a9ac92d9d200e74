// Counts from the residuals of codec 2 (PROTOCOL.md section 10): inflated bytes, folded signs, and a prediction.
namespace Swellcast
{
    internal sealed class Residual
    {
        private readonly Inflate inflate = new Inflate();
        private readonly int[] row = new int[Wire.Tile];
        private byte[] bytes = new byte[0];
        private int next;

        /// <summary>Inflates so many bytes; planes are then restored in order.</summary>
        /// <exception cref="FrameException">It is no deflate stream of so many bytes.</exception>
        public void Begin(byte[] message, int start, int end, int size)
        {
            if (bytes.Length < size) bytes = new byte[size];
            inflate.Run(message, start, end, bytes, size);
            next = 0;
        }

        /// <summary>Fills in the counts of the next plane.</summary>
        public void Restore(bool wide, int depth, ref Basis basis, short[] taps, int n, short[] counts, int offset)
        {
            int low = next, high = next + n * n;
            next += n * n * (wide ? 2 : 1);
            for (int z = 0, i = offset; z < n; z++)
            {
                if (depth == FrameHeader.Between) Predict.Between(taps, ref basis, n, z, row);
                else if (depth > 0) Predict.Past(taps, ref basis, n, z, row);
                for (int x = 0; x < n; x++, i++, low++, high++)
                {
                    int folded = wide ? bytes[low] | bytes[high] << 8 : bytes[low];
                    int predicted = depth > 0 ? row[x] + 2048 >> 12 : Around(counts, i, n, x, z);
                    counts[i] = (short)(predicted + (folded >> 1 ^ -(folded & 1)));
                }
            }
        }

        /// <summary>West + north - north-west; what lies outside is 0.</summary>
        private static int Around(short[] counts, int i, int n, int x, int z)
        {
            int west = x > 0 ? counts[i - 1] : 0, north = z > 0 ? counts[i - n] : 0;
            return west + north - (x > 0 && z > 0 ? counts[i - n - 1] : 0);
        }
    }
}
