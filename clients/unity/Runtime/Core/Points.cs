// Messages of points (PROTOCOL.md section 9): the water at points that a client follows, for buoyancy.
using System;

namespace Swellcast
{
    /// <summary>The water at one point.</summary>
    public struct Water
    {
        /// <summary>Of the displaced surface above the point, metres.</summary>
        public float Height;
        /// <summary>Unit vector of the surface: east, up, south.</summary>
        public float NormalX, NormalY, NormalZ;
        /// <summary>Of the water particle there, m/s: east, up, south.</summary>
        public float VelocityX, VelocityY, VelocityZ;
        /// <summary>0 and below: the surface folds.</summary>
        public float Jacobian;
        /// <summary>Distance between the point and where the particle found is, metres.</summary>
        public float Residual;
        /// <summary>The surface folds here, or no particle was found.</summary>
        public bool Folded;
    }

    /// <summary>All points at one tick. One object is filled again and again.</summary>
    public sealed class PointsMessage
    {
        public const int HeaderBytes = 56, RecordBytes = 40;
        public const int NormalsFlag = 1, VelocitiesFlag = 2, JacobiansFlag = 4;
        private const uint Magic = 0x31505753; // "SWP1"

        public int Count, Flags;
        public long Tick;
        public ulong Epoch, Sequence, Id;
        /// <summary>`Count` of them; the array may be longer.</summary>
        public Water[] Points = new Water[0];

        /// <summary>Whether a binary message is one of points.</summary>
        public static bool Is(byte[] bytes, int offset, int length)
        {
            return length >= 4 && Wire.U32(bytes, offset) == Magic;
        }

        /// <summary>Reads one whole message of at most `most` points.</summary>
        /// <exception cref="FrameException">The message must be dropped; what this then holds is of no use.</exception>
        public void Read(byte[] bytes, int offset, int length, int most)
        {
            if (length < HeaderBytes) throw Refused("length", length, "at least 56");
            if (Wire.U32(bytes, offset) != Magic) throw Refused("magic", Wire.U32(bytes, offset), "SWP1");
            Must("header_bytes", Wire.U16(bytes, offset + 4), HeaderBytes);
            Must("record_bytes", Wire.U16(bytes, offset + 6), RecordBytes);
            uint count = Wire.U32(bytes, offset + 8), flags = Wire.U32(bytes, offset + 12);
            if (count > most) throw Refused("count", count, "at most " + most);
            if (flags > 7) throw Refused("flags", flags, "at most 7");
            ulong tick = Wire.U64(bytes, offset + 16);
            if (tick > Wire.MaxTick) throw FrameException.Header("tick", "is " + tick + ", must be at most 2^53 - 1");
            Must("zero at 52", Wire.U32(bytes, offset + 52), 0);
            Must("length", length, HeaderBytes + (long)count * RecordBytes);
            uint crc = Crc32.Of(0, bytes, offset, 48);
            Must("crc", Wire.U32(bytes, offset + 48), Crc32.Of(crc, bytes, offset + HeaderBytes, length - HeaderBytes));
            Count = (int)count;
            Flags = (int)flags;
            Tick = (long)tick;
            Epoch = Wire.U64(bytes, offset + 24);
            Sequence = Wire.U64(bytes, offset + 32);
            Id = Wire.U64(bytes, offset + 40);
            if (Points.Length < Count) Points = new Water[Count];
            for (int i = 0; i < Count; i++) ReadRecord(bytes, offset + HeaderBytes + i * RecordBytes, i);
        }

        private void ReadRecord(byte[] bytes, int at, int i)
        {
            for (int field = 0; field < 9; field++)
            {
                if (Wire.IsFinite(Float(bytes, at, field))) continue;
                throw FrameException.Header("record " + i, "has a number at " + 4 * field + " that is not finite");
            }
            uint flags = Wire.U32(bytes, at + 36);
            if (flags > 1) throw Refused("flags of record " + i, flags, "at most 1");
            Points[i] = new Water
            {
                Height = Float(bytes, at, 0),
                NormalX = Float(bytes, at, 1),
                NormalY = Float(bytes, at, 2),
                NormalZ = Float(bytes, at, 3),
                VelocityX = Float(bytes, at, 4),
                VelocityY = Float(bytes, at, 5),
                VelocityZ = Float(bytes, at, 6),
                Jacobian = Float(bytes, at, 7),
                Residual = Float(bytes, at, 8),
                Folded = flags == 1,
            };
        }

        private static float Float(byte[] bytes, int at, int field)
        {
            return BitConverter.ToSingle(bytes, at + 4 * field);
        }

        private static void Must(string field, long value, long must)
        {
            if (value != must) throw Refused(field, value, must.ToString());
        }

        private static FrameException Refused(string field, long value, string must)
        {
            return FrameException.Header(field, "is " + value + ", must be " + must);
        }
    }
}
