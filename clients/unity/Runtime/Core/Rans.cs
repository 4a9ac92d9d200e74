// Reads a coded plane (PROTOCOL.md section 10, codec 1): its head, its tables, and that it ends where it should.
namespace Swellcast
{
    /// <summary>Reads planes one after the other; keeps its tables, so that none is allocated for each.</summary>
    public sealed class Rans
    {
        private const int HeadBytes = 28, MostShift = 8;
        private readonly Lanes lanes = new Lanes();
        private readonly int[] row = new int[Wire.Tile];
        private int cursor, limit; // within a table

        /// <summary>Reads a plane of n x n counts; `basis` counts only where `depth` is above 0.</summary>
        /// <param name="start">Where the plane begins.</param>
        /// <param name="end">Where the message ends.</param>
        /// <returns>Where the plane ends.</returns>
        /// <exception cref="FrameException">The bytes are no coded plane; `counts` is of no use then.</exception>
        public int ReadPlane(
            byte[] bytes, int start, int end, int depth, ref Basis basis, short[] taps, int n, short[] counts, int offset)
        {
            if (end - start < HeadBytes) throw FrameException.Payload("is too short for a plane's head");
            int contexts = bytes[start], shift = bytes[start + 1], tableBytes = Wire.U16(bytes, start + 2);
            uint words = Wire.U32(bytes, start + 4), escapes = Wire.U32(bytes, start + 8);
            int samples = n * n;
            if (contexts != 1 && contexts != Lanes.Contexts) throw Wrong("contexts", contexts, "1 or 4");
            int mostShift = contexts == 1 ? MostShift : 0;
            if (shift > mostShift) throw Wrong("shift", shift, "at most " + mostShift);
            if (tableBytes % 2 == 1) throw Wrong("table_bytes", tableBytes, "even");
            if (words > 2 * samples) throw Wrong("words", words, "at most " + 2 * samples);
            if (escapes > samples) throw Wrong("escapes", escapes, "at most " + samples);
            int tables = start + HeadBytes, wordsAt = tables + tableBytes, escapesAt = wordsAt + 2 * (int)words;
            int used = escapesAt + 2 * (int)escapes, after = start + (used - start + 3 & ~3);
            if (after > end) throw FrameException.Payload("has " + (end - start) + " bytes, the plane " + (after - start));
            for (int i = used; i < after; i++)
            {
                if (bytes[i] != 0) throw Wrong("padding", bytes[i], "0");
            }
            ReadTables(bytes, tables, wordsAt, contexts);
            for (int i = 0; i < 4; i++)
            {
                uint state = Wire.U32(bytes, start + 12 + 4 * i);
                if (state < Lanes.Least || state > int.MaxValue) throw Wrong("state", state, "2^15 to 2^31 - 1");
                lanes.States[i] = (int)state;
            }
            lanes.Reserve(samples);
            Wire.CopyU16(bytes, wordsAt, lanes.Words, (int)words);
            Wire.CopyU16(bytes, escapesAt, lanes.Counts, (int)escapes);
            lanes.NextWord = lanes.NextEscape = 0;
            lanes.Quarters = contexts > 1 ? (Lanes.Contexts - 1) << Lanes.SlotBits : 0;
            ReadRows(depth, ref basis, taps, n, shift, counts, offset);
            // An encoder begins with the least state, so that is where a whole plane ends.
            bool whole = lanes.NextWord == words && lanes.NextEscape == escapes;
            for (int i = 0; i < 4; i++) whole &= lanes.States[i] == Lanes.Least;
            if (!whole) throw FrameException.Payload("has a plane that does not end where it should");
            return after;
        }

        private void ReadRows(int depth, ref Basis basis, short[] taps, int n, int shift, short[] counts, int offset)
        {
            for (int z = 0; z < n; z++)
            {
                int at = offset + z * n;
                if (depth == 0) Predict.Above(taps, counts, offset, n, z, row);
                else if (depth == FrameHeader.Between) Predict.Between(taps, ref basis, n, z, row);
                else Predict.Past(taps, ref basis, n, z, row);
                if (shift > 0) lanes.ReadShifted(row, taps, depth == 0, shift, n, z, counts, at);
                else if (depth == 0) lanes.ReadSpace(row, taps, n, z, counts, at);
                else lanes.ReadRow(row, n, counts, at);
            }
        }

        private void ReadTables(byte[] bytes, int begin, int end, int contexts)
        {
            cursor = begin;
            limit = end;
            for (int context = 0; context < contexts; context++) ReadTable(bytes, context * Lanes.Slots);
            int left = limit - cursor;
            if (left > 1 || (left == 1 && bytes[cursor] != 0)) throw FrameException.Payload("has bytes after the tables");
        }

        /// <summary>Fills in the table whose first slot is `first`.</summary>
        private void ReadTable(byte[] bytes, int first)
        {
            int symbol = NextByte(bytes), last = symbol + NextByte(bytes), filled = 0;
            if (last > 255) throw Wrong("last symbol", last - 128, "at most 127");
            for (; symbol <= last; symbol++)
            {
                int share = NextByte(bytes);
                if (share >= 128) share = share & 127 | NextByte(bytes) << 7;
                if (filled + share > Lanes.Slots) throw Wrong("slots of a table", filled + share, "1024");
                int entry = symbol - 128 << 24 | share << 12;
                for (int place = 0; place < share; place++) lanes.Table[first + filled + place] = entry | place;
                filled += share;
            }
            if (filled != Lanes.Slots) throw Wrong("slots of a table", filled, "1024");
        }

        private int NextByte(byte[] bytes)
        {
            if (cursor >= limit) throw FrameException.Payload("has a table that ends early");
            return bytes[cursor++];
        }

        private static FrameException Wrong(string what, long value, string must)
        {
            return FrameException.Payload("has " + what + " " + value + ", must be " + must);
        }
    }
}
