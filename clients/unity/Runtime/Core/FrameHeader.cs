// The header of a frame (PROTOCOL.md section 5): every field read, and every wrong one refused.
using System;
using System.Globalization;

namespace Swellcast
{
    /// <summary>What a frame says about itself. One object is filled again and again.</summary>
    public sealed class FrameHeader
    {
        public const int KeyFlag = 1, SaturatedFlag = 2;
        /// <summary>Frames of the lowest rate that a prediction may reach back to.</summary>
        public const int MaxDepth = 3;
        /// <summary>Depth of a frame that is predicted from those on both sides of it.</summary>
        public const int Between = 4;
        private const uint Magic = 0x31465753; // "SWF1"

        public int Cascade, Level, Class, Group, Codec, Flags;
        /// <summary>Samples a side of this tile, and of the whole patch at this level.</summary>
        public int N, LevelN;
        /// <summary>Position in the patch, counted in tiles.</summary>
        public int TileX, TileZ;
        public int Channels, Depth;
        public long Tick;
        public ulong Epoch, Sequence;
        /// <summary>Changes of layout in effect at its tick.</summary>
        public uint Layout;
        public int PayloadBytes;
        /// <summary>Per channel: a sample is its count times this.</summary>
        public readonly float[] Step = new float[Wire.MaxChannels];
        /// <summary>Per channel: guaranteed largest error before a sample was clamped.</summary>
        public readonly float[] MaxError = new float[Wire.MaxChannels];

        public bool IsKey { get { return (Flags & KeyFlag) != 0; } }
        public bool IsSaturated { get { return (Flags & SaturatedFlag) != 0; } }
        /// <summary>Samples of all channels.</summary>
        public int Samples { get { return Channels * N * N; } }

        /// <summary>Reads the header of one whole message, and checks message and payload against it.</summary>
        /// <exception cref="FrameException">The message must be dropped; what this then holds is of no use.</exception>
        public void Read(byte[] bytes, int offset, int length)
        {
            if (length < Wire.HeaderBytes) throw Refused("length", length, "at least 88");
            if (Wire.U32(bytes, offset) != Magic) throw Refused("magic", Wire.U32(bytes, offset), Magic);
            int headerBytes = Wire.U16(bytes, offset + 4);
            if (headerBytes != Wire.HeaderBytes) throw Refused("header_bytes", headerBytes, "88");
            ReadUnit(bytes, offset);
            ReadShape(bytes, offset);
            ReadTime(bytes, offset);
            ReadErrors(bytes, offset);
            ReadPayload(bytes, offset, length);
        }

        private void ReadUnit(byte[] bytes, int offset)
        {
            Cascade = bytes[offset + 6];
            Level = bytes[offset + 7];
            Class = bytes[offset + 8];
            Group = bytes[offset + 9];
            Codec = bytes[offset + 10];
            Flags = bytes[offset + 11];
            if (Class >= Names.Classes.Length) throw Refused("class", Class, "at most " + (Names.Classes.Length - 1));
            if (Group >= Names.Groups.Length) throw Refused("group", Group, "at most " + (Names.Groups.Length - 1));
            if (Codec >= Names.Codecs.Length) throw Refused("codec", Codec, "at most " + (Names.Codecs.Length - 1));
            if ((Flags & ~(KeyFlag | SaturatedFlag)) != 0) throw Refused("flags", Flags, "at most 3");
        }

        private void ReadShape(byte[] bytes, int offset)
        {
            N = Wire.U16(bytes, offset + 12);
            LevelN = Wire.U16(bytes, offset + 14);
            TileX = Wire.U16(bytes, offset + 16);
            TileZ = Wire.U16(bytes, offset + 18);
            Channels = Wire.U16(bytes, offset + 20);
            if (N < 8 || N > Wire.Tile || (N & N - 1) != 0) throw Refused("n", N, "a power of two, 8 to 256");
            if (LevelN == 0 || LevelN % N != 0) throw Refused("level_n", LevelN, "a multiple of n, which is " + N);
            if (LevelN != N && N != Wire.Tile) throw Refused("level_n", LevelN, "n, which is " + N + ", below 256");
            int across = LevelN / N;
            if (TileX >= across) throw Refused("tile_x", TileX, "below " + across);
            if (TileZ >= across) throw Refused("tile_z", TileZ, "below " + across);
            int channels = Names.GroupChannels[Group];
            if (Channels != channels) throw Refused("channels", Channels, channels + " of " + Names.Groups[Group]);
        }

        private void ReadTime(byte[] bytes, int offset)
        {
            if (bytes[offset + 23] != 0) throw Refused("zero at 23", bytes[offset + 23], "0");
            uint zero = Wire.U32(bytes, offset + 84);
            if (zero != 0) throw Refused("zero at 84", zero, "0");
            ulong tick = Wire.U64(bytes, offset + 24);
            if (tick > Wire.MaxTick) throw FrameException.Header("tick", "is " + tick + ", must be at most 2^53 - 1");
            Tick = (long)tick;
            Epoch = Wire.U64(bytes, offset + 32);
            Sequence = Wire.U64(bytes, offset + 40);
            Layout = Wire.U32(bytes, offset + 48);
            Depth = bytes[offset + 22];
            if (IsKey && Depth != 0) throw Refused("depth", Depth, "0 of a key frame");
            int layer = Wire.LayerOf(Tick);
            bool possible = Depth == 0 || Swellcast.Codec.Predicts(Codec)
                && (layer == 0 ? Depth <= MaxDepth : layer < 3 && Depth == Between);
            if (!possible)
            {
                throw Refused("depth", Depth, "what codec " + Names.Codecs[Codec] + " has at tick " + Tick);
            }
        }

        private void ReadErrors(byte[] bytes, int offset)
        {
            // The bits of a float above zero and finite lie between those of 0 and of infinity.
            for (int c = 0; c < Wire.MaxChannels; c++)
            {
                int stepAt = offset + 56 + 4 * c, errorAt = offset + 68 + 4 * c;
                Step[c] = BitConverter.ToSingle(bytes, stepAt);
                MaxError[c] = BitConverter.ToSingle(bytes, errorAt);
                bool there = c < Channels, exact = Codec == Swellcast.Codec.F32;
                CheckFloat("step", c, Step[c], Wire.U32(bytes, stepAt), there);
                CheckFloat("max_error", c, MaxError[c], Wire.U32(bytes, errorAt), there && !exact);
            }
        }

        private static void CheckFloat(string field, int channel, float value, uint bits, bool positive)
        {
            bool good = positive ? bits > 0 && bits < 0x7f800000 : value == 0;
            if (good) return;
            string must = positive ? "finite and above 0" : "0";
            string shown = value.ToString(CultureInfo.InvariantCulture);
            throw FrameException.Header(field, "of channel " + channel + " is " + shown + ", must be " + must);
        }

        private void ReadPayload(byte[] bytes, int offset, int length)
        {
            uint payload = Wire.U32(bytes, offset + 52);
            int samples = Samples;
            long least, most;
            if (Swellcast.Codec.Predicts(Codec))
            {
                least = 1;
                most = samples * 4 + Wire.TablesBytes;
            }
            else
            {
                least = most = samples * (Codec == Swellcast.Codec.F32 ? 4 : 2);
            }
            if (payload < least || payload > most) throw Refused("payload_bytes", payload, least + " to " + most);
            PayloadBytes = (int)payload;
            int follow = length - Wire.HeaderBytes;
            if (follow != PayloadBytes)
            {
                throw FrameException.Header("payload", "has " + follow + " bytes, must have " + PayloadBytes);
            }
            uint crc = Crc32.Of(Crc32.Of(0, bytes, offset, 80), bytes, offset + Wire.HeaderBytes, PayloadBytes);
            uint said = Wire.U32(bytes, offset + 80);
            if (crc != said) throw Refused("crc", said, crc);
        }

        private static FrameException Refused(string field, long value, long must)
        {
            return Refused(field, value, must.ToString(CultureInfo.InvariantCulture));
        }

        private static FrameException Refused(string field, long value, string must)
        {
            string shown = value.ToString(CultureInfo.InvariantCulture);
            return FrameException.Header(field, "is " + shown + ", must be " + must);
        }
    }
}
