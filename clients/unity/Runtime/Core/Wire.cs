// Numbers as they stand on the wire: little-endian, at any offset of a byte array. And the names that go with them.
using System;

namespace Swellcast
{
    /// <summary>Constants and readers of the wire (PROTOCOL.md section 5).</summary>
    public static class Wire
    {
        public const string Subprotocol = "swellcast.v1";
        public const int TicksPerSecond = 7200;
        /// <summary>2^53 - 1: the largest tick, and the largest whole number that JSON carries exactly.</summary>
        public const long MaxTick = (1L << 53) - 1;
        /// <summary>Samples a side of the largest tile.</summary>
        public const int Tile = 256;
        public const int MaxChannels = 3;
        /// <summary>Beside its samples a coded frame is never longer.</summary>
        public const int TablesBytes = 8192;
        public const int HeaderBytes = 88;
        /// <summary>The largest frame: three planes of floats, and tables.</summary>
        public const int MaxFrameBytes = HeaderBytes + MaxChannels * Tile * Tile * 4 + TablesBytes;
        /// <summary>Ticks between frames of the lowest layer: 15 a second.</summary>
        public const int SlowestInterval = 480;
        /// <summary>A cascade that ends is zero for this long before its last tick.</summary>
        public const int RestTicks = 1440;

        public static int U16(byte[] bytes, int at)
        {
            return bytes[at] | bytes[at + 1] << 8;
        }

        public static int I16(byte[] bytes, int at)
        {
            return (short)U16(bytes, at);
        }

        public static uint U32(byte[] bytes, int at)
        {
            return (uint)(U16(bytes, at) | U16(bytes, at + 2) << 16);
        }

        public static ulong U64(byte[] bytes, int at)
        {
            return U32(bytes, at) | (ulong)U32(bytes, at + 4) << 32;
        }

        /// <summary>Reads 16-bit numbers into an array; both have two bytes an element.</summary>
        public static void CopyU16(byte[] bytes, int at, Array into, int count)
        {
            if (BitConverter.IsLittleEndian)
            {
                Buffer.BlockCopy(bytes, at, into, 0, count * 2);
                return;
            }
            for (int i = 0; i < count; i++)
            {
                Buffer.SetByte(into, 2 * i, bytes[at + 2 * i + 1]);
                Buffer.SetByte(into, 2 * i + 1, bytes[at + 2 * i]);
            }
        }

        public static bool IsFinite(float value)
        {
            return !float.IsNaN(value) && !float.IsInfinity(value);
        }

        public static bool IsFinite(double value)
        {
            return !double.IsNaN(value) && !double.IsInfinity(value);
        }

        /// <summary>
        /// The layer of a tick in time: 0, 1 and 2 come at 15, 30 and 60 Hz; 3 is no layer of a predicted frame.
        /// </summary>
        public static int LayerOf(long tick)
        {
            return tick % 480 == 0 ? 0 : tick % 240 == 0 ? 1 : tick % 120 == 0 ? 2 : 3;
        }
    }
}
