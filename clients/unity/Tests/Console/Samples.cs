// Messages and frames for tests, straight from the tables of PROTOCOL.md; the CRC is the slow, obvious one.
using System;

namespace Swellcast.Tests
{
    internal static class Samples
    {
        public const ulong Epoch = 0xab54a98ceb1f0ad2;

        /// <summary>A hello of cascade 1 with 8 samples a side of 64 m.</summary>
        public static string Hello(ulong epoch = Epoch, string cascades = null, int n = 8)
        {
            string one = cascades ?? CascadeOf(1, n, 0, null);
            return "{\"type\":\"hello\",\"protocol\":1,\"server\":\"s\",\"scene\":\"default\",\"epoch\":\""
                + epoch.ToString("x16") + "\",\"seed\":\"1\",\"ticks_per_second\":7200,\"tick\":1,\"lead_ticks\":1680,"
                + "\"sequence\":0,\"layout\":{\"generation\":1,\"cascades\":[" + one + "]},\"choppiness\":1,"
                + "\"rates_hz\":[15,30],\"classes\":[{\"name\":\"1mm\",\"displacement_m\":0.001,\"slope\":0.002,"
                + "\"foam\":0.004,\"velocity_mps\":0.002}],\"groups\":[{\"name\":\"displacement\",\"channels\":[]},"
                + "{\"name\":\"foam\",\"channels\":[]}],\"foam_step_ticks\":720,"
                + "\"limits\":{\"message_bytes\":4096,\"units\":8,\"live_units\":8,\"points\":2}}";
        }

        public static string CascadeOf(int index, int n, long from, long? until)
        {
            return "{\"index\":" + index + ",\"patch_m\":64,\"n\":" + n + ",\"levels\":2,\"wavelength_min_m\":1,"
                + "\"wavelength_max_m\":9,\"from_tick\":" + from + ",\"until_tick\":"
                + (until == null ? "null" : until.ToString()) + "}";
        }

        /// <summary>
        /// A frame of codec `i16`, each count made by its channel and place, or of the payload given.
        /// </summary>
        public static byte[] Frame(
            int group = Group.Displacement, long tick = 7200, int n = 8, int cascade = 1, int level = 0, int codec = 0,
            int depth = 0, ulong epoch = Epoch, Func<int, int, int, int> count = null, byte[] payload = null)
        {
            int channels = Names.GroupChannels[group];
            var bytes = new byte[88 + (payload == null ? channels * n * n * 2 : payload.Length)];
            Put(bytes, 0, 0x31465753, 4);
            Put(bytes, 4, 88, 2);
            bytes[6] = (byte)cascade;
            bytes[7] = (byte)level;
            bytes[8] = 1;
            bytes[9] = (byte)group;
            bytes[10] = (byte)codec;
            bytes[11] = (byte)(depth == 0 ? 1 : 0);
            Put(bytes, 12, n, 2);
            Put(bytes, 14, n, 2);
            Put(bytes, 20, channels, 2);
            bytes[22] = (byte)depth;
            Put(bytes, 24, tick, 8);
            Put(bytes, 32, (long)epoch, 8);
            Put(bytes, 52, bytes.Length - 88, 4);
            for (int c = 0; c < channels; c++)
            {
                Buffer.BlockCopy(new[] { 0.002f }, 0, bytes, 56 + 4 * c, 4);
                if (codec != Codec.F32) Buffer.BlockCopy(new[] { 0.001f }, 0, bytes, 68 + 4 * c, 4);
            }
            if (payload != null)
            {
                Array.Copy(payload, 0, bytes, 88, payload.Length);
            }
            else
            {
                for (int i = 0; i < channels * n * n; i++)
                {
                    int value = count == null ? i * 7919 : count(i / (n * n), i % n, i / n % n);
                    Put(bytes, 88 + 2 * i, value, 2);
                }
            }
            Seal(bytes);
            return bytes;
        }

        public static void Put(byte[] bytes, int at, long value, int count)
        {
            for (int i = 0; i < count; i++) bytes[at + i] = (byte)(value >> 8 * i);
        }

        /// <summary>Gives a frame the CRC that fits its bytes.</summary>
        public static void Seal(byte[] bytes)
        {
            uint crc = 0xffffffff;
            for (int i = 0; i < bytes.Length; i++)
            {
                if (i >= 80 && i < 88) continue;
                crc ^= bytes[i];
                for (int bit = 0; bit < 8; bit++) crc = (crc & 1) != 0 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
            }
            Put(bytes, 80, ~crc, 4);
        }

        /// <summary>
        /// The payload of one still plane of foam with codec `rans`, predicted from the frame before.
        /// </summary>
        public static byte[] StillFoam()
        {
            var payload = new byte[20 + 28 + 4];
            Put(payload, 0, 4096, 2); // tap 0
            payload[20] = 1; // contexts
            Put(payload, 22, 4, 2); // table_bytes
            for (int state = 0; state < 4; state++) Put(payload, 32 + 4 * state, 1 << 15, 4);
            payload[48] = 128; // the symbol 0 alone
            payload[50] = 0x80;
            payload[51] = 1024 >> 7;
            return payload;
        }
    }
}
