// A raw deflate stream (RFC 1951) into a buffer of known size: nothing is allocated, and no stream, however made, gives
// more than was asked for.
using System;

namespace Swellcast
{
    internal sealed class Inflate
    {
        private static readonly int[] LengthBase = Bases(29, 4, 3), DistanceBase = Bases(30, 2, 1);
        /// <summary>The order in which lengths of code lengths are sent.</summary>
        private static readonly int[] Order = { 16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15 };
        private const int Literals = 288, Distances = 32, End = 256;

        private readonly Huffman literals = new Huffman(Literals), distances = new Huffman(Distances);
        private readonly Huffman lengthCodes = new Huffman(19);
        private readonly byte[] lengths = new byte[Literals + Distances];
        private byte[] input, output;
        private int at, end, filled, size;
        private uint bits;
        private int held; // bits of `bits` that are of the stream

        /// <summary>What symbols stand for, where each further `group` of them has one extra bit more.</summary>
        private static int[] Bases(int count, int group, int first)
        {
            var bases = new int[count];
            for (int i = 0; i < count; i++)
            {
                bases[i] = first;
                first += 1 << Extra(i, group);
            }
            return bases;
        }

        private static int Extra(int symbol, int group)
        {
            return symbol < 2 * group ? 0 : symbol / group - 1;
        }

        /// <summary>Fills exactly `size` bytes of `output`; what stands behind the stream has no meaning.</summary>
        /// <exception cref="FrameException">It is no deflate stream of so many bytes.</exception>
        public void Run(byte[] input, int start, int end, byte[] output, int size)
        {
            this.input = input;
            this.output = output;
            this.end = end;
            this.size = size;
            at = start;
            bits = 0;
            held = filled = 0;
            for (bool last = false; !last;)
            {
                last = Take(1) == 1;
                int kind = Take(2);
                if (kind == 0) Stored();
                else if (kind == 1) Fixed();
                else if (kind == 2) Dynamic();
                else throw Wrong("has a block of kind 3");
            }
            if (filled != size) throw Wrong("gives " + filled + " bytes, must give " + size);
        }

        private static FrameException Wrong(string why)
        {
            return FrameException.Payload("is no deflate stream: it " + why);
        }

        /// <summary>Makes at least 25 bits ready, as long as there are any.</summary>
        private void Fill()
        {
            while (held <= 24 && at < end)
            {
                bits |= (uint)input[at++] << held;
                held += 8;
            }
        }

        private void Drop(int count)
        {
            if (count > held) throw Wrong("ends early");
            bits >>= count;
            held -= count;
        }

        private int Take(int count)
        {
            Fill();
            var value = (int)(bits & (1u << count) - 1);
            Drop(count);
            return value;
        }

        private int Symbol(Huffman code)
        {
            Fill();
            int length, symbol = code.Find(bits, out length);
            if (symbol < 0) throw Wrong("has a code that is none");
            Drop(length);
            return symbol;
        }

        private void Stored()
        {
            Drop(held & 7);
            int count = Take(16), inverted = Take(16);
            if (count != (inverted ^ 0xffff)) throw Wrong("has a stored block of wrong length");
            if (count > size - filled) throw Wrong("gives more than " + size + " bytes");
            for (; count > 0 && held > 0; count--) output[filled++] = (byte)Take8();
            if (count > end - at) throw Wrong("ends early");
            Buffer.BlockCopy(input, at, output, filled, count);
            at += count;
            filled += count;
        }

        /// <summary>A byte that is held already: no others are fetched.</summary>
        private uint Take8()
        {
            uint value = bits & 255;
            Drop(8);
            return value;
        }

        private void Fixed()
        {
            for (int i = 0; i < Literals; i++) lengths[i] = (byte)(i < 144 ? 8 : i < 256 ? 9 : i < 280 ? 7 : 8);
            for (int i = 0; i < Distances; i++) lengths[Literals + i] = 5;
            literals.Set(lengths, 0, Literals);
            distances.Set(lengths, Literals, Distances);
            Symbols();
        }

        private void Dynamic()
        {
            int ofLiterals = Take(5) + 257, ofDistances = Take(5) + 1, ofLengths = Take(4) + 4;
            if (ofLiterals > 286 || ofDistances > 30) throw Wrong("has too many codes");
            Array.Clear(lengths, 0, lengths.Length);
            for (int i = 0; i < ofLengths; i++) lengths[Order[i]] = (byte)Take(3);
            if (!lengthCodes.Set(lengths, 0, 19)) throw Wrong("has codes that exclude one another");
            Array.Clear(lengths, 0, 19);
            int all = ofLiterals + ofDistances;
            for (int i = 0; i < all;)
            {
                int symbol = Symbol(lengthCodes);
                if (symbol < 16)
                {
                    lengths[i++] = (byte)symbol;
                    continue;
                }
                if (symbol == 16 && i == 0) throw Wrong("repeats a length that is none");
                byte again = symbol == 16 ? lengths[i - 1] : (byte)0;
                int times = symbol == 16 ? 3 + Take(2) : symbol == 17 ? 3 + Take(3) : 11 + Take(7);
                if (times > all - i) throw Wrong("has too many lengths");
                while (times-- > 0) lengths[i++] = again;
            }
            bool good = literals.Set(lengths, 0, ofLiterals) & distances.Set(lengths, ofLiterals, ofDistances);
            if (!good) throw Wrong("has codes that exclude one another");
            Symbols();
        }

        private void Symbols()
        {
            for (;;)
            {
                int symbol = Symbol(literals);
                if (symbol == End) return;
                if (symbol < End)
                {
                    if (filled == size) throw Wrong("gives more than " + size + " bytes");
                    output[filled++] = (byte)symbol;
                    continue;
                }
                Repeat(symbol - 257);
            }
        }

        private void Repeat(int symbol)
        {
            if (symbol > 28) throw Wrong("has length " + symbol);
            int count = symbol == 28 ? 258 : LengthBase[symbol] + Take(Extra(symbol, 4));
            int far = Symbol(distances);
            if (far > 29) throw Wrong("has distance " + far);
            int from = filled - (DistanceBase[far] + Take(Extra(far, 2)));
            if (from < 0) throw Wrong("reaches back to before its beginning");
            if (count > size - filled) throw Wrong("gives more than " + size + " bytes");
            // Byte by byte: what is repeated may be what this writes.
            while (count-- > 0) output[filled++] = output[from++];
        }
    }
}
