// The loops over the samples of a coded plane (PROTOCOL.md section 10, codec 1): rANS of four states in turn.
// What is done for a sample is written out four times, one for each state, so that states stay in registers.
namespace Swellcast
{
    /// <summary>Where reading stands, and what it reads from.</summary>
    internal sealed class Lanes
    {
        public const int SlotBits = 10, Slots = 1 << SlotBits, Contexts = 4;
        /// <summary>The least that a state may be between two samples.</summary>
        public const int Least = 1 << 15;
        private const int Mask = Slots - 1;
        /// <summary>An entry below this is an escape: its symbol is -128.</summary>
        private const int Escapes = -127 << 24;

        /// <summary>
        /// By context and slot: the symbol in 8 bits, its slots in 12, the slot's place among them in 12.
        /// </summary>
        public readonly int[] Table = new int[Contexts * Slots];
        /// <summary>
        /// Room for the most that the samples can take, two words and an escape each: no index needs a check of ours,
        /// and who read further than what was sent is found out at the end.
        /// </summary>
        public ushort[] Words = new ushort[0];
        public short[] Counts = new short[0];
        public readonly int[] States = new int[4];
        public int NextWord, NextEscape;
        /// <summary>Bits of a prediction that choose its table; as it happens, also where that begins.</summary>
        public int Quarters;

        /// <summary>Makes room for planes of so many samples.</summary>
        public void Reserve(int samples)
        {
            if (Counts.Length >= samples) return;
            Words = new ushort[2 * samples];
            Counts = new short[samples];
        }

        /// <summary>Reads a row of which the predictions are known.</summary>
        public void ReadRow(int[] row, int n, short[] counts, int at)
        {
            int[] table = Table;
            ushort[] words = Words;
            int x0 = States[0], x1 = States[1], x2 = States[2], x3 = States[3], w = NextWord, quarters = Quarters;
            for (int x = 0; x < n; x += 4, at += 4)
            {
                int p = row[x], t = table[p & quarters | x0 & Mask];
                x0 = (t >> 12 & 0xfff) * (x0 >> SlotBits) + (t & 0xfff);
                if (x0 < Least) x0 = x0 << 16 | words[w++];
                counts[at] = t < Escapes ? Counts[NextEscape++] : (short)((p >> 12) + (t >> 24));

                p = row[x + 1];
                t = table[p & quarters | x1 & Mask];
                x1 = (t >> 12 & 0xfff) * (x1 >> SlotBits) + (t & 0xfff);
                if (x1 < Least) x1 = x1 << 16 | words[w++];
                counts[at + 1] = t < Escapes ? Counts[NextEscape++] : (short)((p >> 12) + (t >> 24));

                p = row[x + 2];
                t = table[p & quarters | x2 & Mask];
                x2 = (t >> 12 & 0xfff) * (x2 >> SlotBits) + (t & 0xfff);
                if (x2 < Least) x2 = x2 << 16 | words[w++];
                counts[at + 2] = t < Escapes ? Counts[NextEscape++] : (short)((p >> 12) + (t >> 24));

                p = row[x + 3];
                t = table[p & quarters | x3 & Mask];
                x3 = (t >> 12 & 0xfff) * (x3 >> SlotBits) + (t & 0xfff);
                if (x3 < Least) x3 = x3 << 16 | words[w++];
                counts[at + 3] = t < Escapes ? Counts[NextEscape++] : (short)((p >> 12) + (t >> 24));
            }
            Keep(x0, x1, x2, x3, w);
        }

        /// <summary>
        /// Reads a row whose predictions need its own samples too: `row` has what the rows above say.
        /// </summary>
        public void ReadSpace(int[] row, short[] taps, int n, int z, short[] counts, int at)
        {
            int[] table = Table;
            ushort[] words = Words;
            int x0 = States[0], x1 = States[1], x2 = States[2], x3 = States[3], w = NextWord, quarters = Quarters;
            int w0 = z == 0 ? 1 << 12 : taps[0], w4 = z == 0 ? 0 : taps[4], w7 = z == 0 ? 0 : taps[7];
            int west = 0, far = 0;
            for (int x = 0; x < n; x += 4, at += 4)
            {
                int p = row[x] + w4 * far + w0 * west + (w7 * west >> 4), t = table[p & quarters | x0 & Mask];
                x0 = (t >> 12 & 0xfff) * (x0 >> SlotBits) + (t & 0xfff);
                if (x0 < Least) x0 = x0 << 16 | words[w++];
                far = west;
                counts[at] = (short)(west = t < Escapes ? Counts[NextEscape++] : (short)((p >> 12) + (t >> 24)));
                if (x == 0) far = west; // the second column has nothing two to the west

                p = row[x + 1] + w4 * far + w0 * west + (w7 * west >> 4);
                t = table[p & quarters | x1 & Mask];
                x1 = (t >> 12 & 0xfff) * (x1 >> SlotBits) + (t & 0xfff);
                if (x1 < Least) x1 = x1 << 16 | words[w++];
                far = west;
                counts[at + 1] = (short)(west = t < Escapes ? Counts[NextEscape++] : (short)((p >> 12) + (t >> 24)));

                p = row[x + 2] + w4 * far + w0 * west + (w7 * west >> 4);
                t = table[p & quarters | x2 & Mask];
                x2 = (t >> 12 & 0xfff) * (x2 >> SlotBits) + (t & 0xfff);
                if (x2 < Least) x2 = x2 << 16 | words[w++];
                far = west;
                counts[at + 2] = (short)(west = t < Escapes ? Counts[NextEscape++] : (short)((p >> 12) + (t >> 24)));

                p = row[x + 3] + w4 * far + w0 * west + (w7 * west >> 4);
                t = table[p & quarters | x3 & Mask];
                x3 = (t >> 12 & 0xfff) * (x3 >> SlotBits) + (t & 0xfff);
                if (x3 < Least) x3 = x3 << 16 | words[w++];
                far = west;
                counts[at + 3] = (short)(west = t < Escapes ? Counts[NextEscape++] : (short)((p >> 12) + (t >> 24)));
            }
            Keep(x0, x1, x2, x3, w);
        }

        /// <summary>Reads a row of either kind whose residuals have low bits of their own.</summary>
        public void ReadShifted(int[] row, short[] taps, bool space, int shift, int n, int z, short[] counts, int at)
        {
            bool first = z == 0;
            int w0 = !space ? 0 : first ? 1 << 12 : taps[0];
            int w4 = space && !first ? taps[4] : 0, w7 = space && !first ? taps[7] : 0;
            int low = (1 << shift) - 1, west = 0, far = 0;
            for (int x = 0; x < n; x++, at++)
            {
                int p = row[x] + w4 * far + w0 * west + (w7 * west >> 4), state = States[x & 3];
                int t = Table[state & Mask];
                state = (t >> 12 & 0xfff) * (state >> SlotBits) + (t & 0xfff);
                if (state < Least) state = state << 16 | Words[NextWord++];
                int residual = (t >> 24 << shift) + (state & low);
                state >>= shift;
                if (state < Least) state = state << 16 | Words[NextWord++];
                States[x & 3] = state;
                short count = t < Escapes ? Counts[NextEscape++] : (short)((p >> 12) + residual);
                far = x == 0 ? count : west;
                west = count;
                counts[at] = count;
            }
        }

        private void Keep(int x0, int x1, int x2, int x3, int w)
        {
            States[0] = x0;
            States[1] = x1;
            States[2] = x2;
            States[3] = x3;
            NextWord = w;
        }
    }
}
