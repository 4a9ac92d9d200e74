// A canonical Huffman code of deflate (RFC 1951 section 3.2.2): codes of up to 9 bits by one look into a table, longer
// ones bit by bit.
using System;

namespace Swellcast
{
    internal sealed class Huffman
    {
        public const int MostBits = 15;
        private const int FastBits = 9;
        private readonly ushort[] fast = new ushort[1 << FastBits]; // symbol in 12 bits, length in 4; 0 for longer codes
        private readonly int[] ofLength = new int[MostBits + 1];
        private readonly int[] next = new int[MostBits + 1];
        private readonly ushort[] symbols; // in the order of their codes

        public Huffman(int mostSymbols)
        {
            symbols = new ushort[mostSymbols];
        }

        /// <summary>Sets the code by the length of each symbol's, 0 for those that don't come.</summary>
        /// <returns>false where there are more codes than bits for them.</returns>
        public bool Set(byte[] lengths, int offset, int count)
        {
            Array.Clear(ofLength, 0, ofLength.Length);
            Array.Clear(fast, 0, fast.Length);
            for (int i = 0; i < count; i++) ofLength[lengths[offset + i]]++;
            ofLength[0] = 0;
            int left = 1, place = 0;
            for (int length = 1; length <= MostBits; length++)
            {
                left = (left << 1) - ofLength[length];
                if (left < 0) return false;
                next[length] = place;
                place += ofLength[length];
            }
            for (int i = 0; i < count; i++)
            {
                if (lengths[offset + i] != 0) symbols[next[lengths[offset + i]]++] = (ushort)i;
            }
            FillFast();
            return true;
        }

        private void FillFast()
        {
            int code = 0, place = 0;
            for (int length = 1; length <= FastBits; length++, code <<= 1)
            {
                for (int i = 0; i < ofLength[length]; i++, code++)
                {
                    var entry = (ushort)(symbols[place++] << 4 | length);
                    for (int at = Reversed(code, length); at < fast.Length; at += 1 << length) fast[at] = entry;
                }
            }
        }

        /// <summary>Codes stand in the stream with their first bit lowest.</summary>
        private static int Reversed(int code, int length)
        {
            int reversed = 0;
            for (int i = 0; i < length; i++) reversed |= (code >> i & 1) << length - 1 - i;
            return reversed;
        }

        /// <summary>The symbol that `bits` begin with, and in `length` how many bits it has; -1 for no code.</summary>
        public int Find(uint bits, out int length)
        {
            int entry = fast[bits & (1 << FastBits) - 1];
            length = entry & 15;
            if (entry != 0) return entry >> 4;
            int code = 0, first = 0, place = 0;
            for (length = 1; length <= MostBits; length++)
            {
                code |= (int)(bits & 1);
                bits >>= 1;
                int there = ofLength[length];
                if (code - first < there) return symbols[place + code - first];
                place += there;
                first = first + there << 1;
                code <<= 1;
            }
            return -1;
        }
    }
}
