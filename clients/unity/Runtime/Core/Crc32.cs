// CRC-32 (IEEE 802.3, as zlib), eight bytes a step.
namespace Swellcast
{
    public static class Crc32
    {
        private static readonly uint[] Table = MakeTable();

        /// <summary>Row k is what a byte does that lies k bytes before the last of a step.</summary>
        private static uint[] MakeTable()
        {
            var table = new uint[8 * 256];
            for (uint i = 0; i < 256; i++)
            {
                uint crc = i;
                for (int bit = 0; bit < 8; bit++) crc = (crc & 1) != 0 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
                table[i] = crc;
            }
            for (int i = 256; i < table.Length; i++) table[i] = table[i - 256] >> 8 ^ table[table[i - 256] & 255];
            return table;
        }

        /// <summary>Continues a CRC over more bytes; `crc` is what an earlier call returned, 0 to begin.</summary>
        public static uint Of(uint crc, byte[] bytes, int offset, int count)
        {
            uint[] t = Table;
            uint c = ~crc;
            int at = offset, end = offset + count, steps = offset + (count & ~7);
            for (; at < steps; at += 8)
            {
                c ^= Wire.U32(bytes, at);
                c = t[1792 + (int)(c & 255)] ^ t[1536 + (int)(c >> 8 & 255)] ^ t[1280 + (int)(c >> 16 & 255)]
                    ^ t[1024 + (int)(c >> 24)] ^ t[768 + bytes[at + 4]] ^ t[512 + bytes[at + 5]]
                    ^ t[256 + bytes[at + 6]] ^ t[bytes[at + 7]];
            }
            for (; at < end; at++) c = c >> 8 ^ t[(int)((c ^ bytes[at]) & 255)];
            return ~c;
        }

        /// <summary>Continues a CRC over counts as they stand on the wire: little-endian.</summary>
        public static uint OfCounts(uint crc, short[] counts, int offset, int count)
        {
            uint c = ~crc;
            for (int i = offset; i < offset + count; i++)
            {
                c = c >> 8 ^ Table[(int)((c ^ (uint)counts[i]) & 255)];
                c = c >> 8 ^ Table[(int)((c ^ (uint)(counts[i] >> 8)) & 255)];
            }
            return ~c;
        }
    }
}
