// Binary vectors: every frame decodes to what stands beside it, every wrong one is refused for the field at fault.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.IO;

namespace Swellcast.Tests
{
    internal static class VectorTests
    {
        public static void Add(Tests tests)
        {
            tests.Add("vectors: frames", Frames);
            tests.Add("vectors: streams, in the order in which they are sent", Streams);
            tests.Add("vectors: invalid headers", InvalidHeaders);
            tests.Add("vectors: invalid payloads", InvalidPayloads);
            tests.Add("vectors: points", Points);
        }

        private static Frame Decode(Decoder decoder, byte[] message)
        {
            // At an offset, as part of a larger buffer.
            var bytes = new byte[message.Length + 7];
            Array.Copy(message, 0, bytes, 3, message.Length);
            return decoder.Decode(bytes, 3, message.Length);
        }

        private static void Frames()
        {
            foreach (string file in Vectors.Files("", ".bin"))
            {
                string name = Path.GetFileNameWithoutExtension(file);
                Frame frame = Decode(new Decoder(0), File.ReadAllBytes(file));
                JsonValue said = Vectors.Json(name + ".json"), header = said["header"];
                FrameHeader h = frame.Header;
                var fields = new Dictionary<string, double>
                {
                    { "cascade", h.Cascade }, { "level", h.Level }, { "class", h.Class }, { "group", h.Group },
                    { "codec", h.Codec }, { "flags", h.Flags }, { "n", h.N }, { "level_n", h.LevelN },
                    { "tile_x", h.TileX }, { "tile_z", h.TileZ }, { "channels", h.Channels }, { "depth", h.Depth },
                    { "layout", h.Layout }, { "payload_bytes", h.PayloadBytes },
                };
                foreach (KeyValuePair<string, double> field in fields)
                {
                    Check.Same(field.Value, header[field.Key].Number, name + ": " + field.Key);
                }
                Check.Same(h.Tick.ToString(), header["tick"].Text, name + ": tick");
                Check.Same(h.Epoch.ToString(), header["epoch"].Text, name + ": epoch");
                Check.Same(h.Sequence.ToString(), header["sequence"].Text, name + ": sequence");
                for (int c = 0; c < Wire.MaxChannels; c++)
                {
                    Check.Same(h.Step[c], (float)header["step"].Items[c].Number, name + ": step");
                    Check.Same(h.MaxError[c], (float)header["max_error"].Items[c].Number, name + ": max_error");
                }
                Check.Same(said["planes"].Items.Count, h.Channels, name + ": planes");
                for (int c = 0; c < h.Channels; c++) Plane(name, frame, c, said["planes"].Items[c]);
            }
        }

        private static void Plane(string name, Frame frame, int channel, JsonValue said)
        {
            int samples = frame.Header.N * frame.Header.N;
            if (said["counts"] != null)
            {
                for (int i = 0; i < samples; i++)
                {
                    int count = frame.Counts[channel * samples + i];
                    Check.Same(count, (int)said["counts"].Items[i].Number, name + ": count " + i);
                }
            }
            uint crc = Crc32.OfCounts(0, frame.Counts, channel * samples, samples);
            Check.Same(crc, (uint)said["crc32"].Number, name + ": crc of channel " + channel);
        }

        private static void Streams()
        {
            foreach (string file in Vectors.Files("streams", ".frames"))
            {
                string name = Path.GetFileNameWithoutExtension(file);
                var decoder = new Decoder(1 << 20);
                List<JsonValue> said = Vectors.Json("streams/" + name + ".json")["frames"].Items;
                List<byte[]> frames = Vectors.Split(File.ReadAllBytes(file));
                Check.Same(frames.Count, said.Count, name);
                for (int i = 0; i < frames.Count; i++)
                {
                    Frame frame = Decode(decoder, frames[i]);
                    FrameHeader h = frame.Header;
                    string where = name + ", frame " + i;
                    Check.Same(frames[i].Length, (int)said[i]["bytes"].Number, where);
                    Check.Same(h.Tick.ToString(), said[i]["tick"].Text, where);
                    Check.Same(h.Depth, (int)said[i]["depth"].Number, where);
                    Check.Same(h.Flags, (int)said[i]["flags"].Number, where);
                    for (int c = 0; c < h.Channels; c++)
                    {
                        Check.Same(CrcOf(frame, c), (uint)said[i]["crc32"].Items[c].Number, where + ", channel " + c);
                    }
                }
            }
        }

        private static uint CrcOf(Frame frame, int channel)
        {
            int samples = frame.Header.N * frame.Header.N;
            if (frame.IsCounts) return Crc32.OfCounts(0, frame.Counts, channel * samples, samples);
            var bytes = new byte[4 * samples];
            Buffer.BlockCopy(frame.Floats, 4 * channel * samples, bytes, 0, bytes.Length);
            return Crc32.Of(0, bytes, 0, bytes.Length);
        }

        private static void InvalidHeaders()
        {
            List<JsonValue> index = Vectors.Json("invalid/index.json").Items;
            Check.Same(Vectors.Files("invalid", ".bin").Length, index.Count, "vectors of the index");
            foreach (JsonValue vector in index)
            {
                string name = vector["file"].Text;
                byte[] bytes = Vectors.Bytes("invalid/" + name);
                var error = Check.Throws<FrameException>(() => Decode(new Decoder(1 << 20), bytes), name);
                Check.Same(error.Field, vector["field"].Text, name + ", refused as \"" + error.Message + "\"");
                Check.Same(error.Fault, Fault.Header, name);
            }
        }

        private static void InvalidPayloads()
        {
            List<JsonValue> index = Vectors.Json("invalid/payloads/index.json").Items;
            Check.Same(Vectors.Files("invalid/payloads", ".bin").Length, index.Count, "vectors of the index");
            foreach (JsonValue vector in index)
            {
                string name = vector["file"].Text;
                byte[] bytes = Vectors.Bytes("invalid/payloads/" + name);
                var error = Check.Throws<FrameException>(() => Decode(new Decoder(1 << 20), bytes), name);
                Fault must = name == "reference.bin" ? Fault.Missing : Fault.Payload;
                Check.Same(error.Fault, must, name + ", refused as \"" + error.Message + "\"");
            }
        }

        private static void Points()
        {
            foreach (string file in Vectors.Files("points", ".bin"))
            {
                string name = Path.GetFileNameWithoutExtension(file);
                byte[] bytes = File.ReadAllBytes(file);
                JsonValue said = Vectors.Json("points/" + name + ".json");
                var message = new PointsMessage();
                Check.That(PointsMessage.Is(bytes, 0, bytes.Length), name + " is of points");
                message.Read(bytes, 0, bytes.Length, 2000);
                Check.Same(message.Tick.ToString(), said["tick"].Text, name);
                Check.Same(message.Epoch.ToString(), said["epoch"].Text, name);
                Check.Same(message.Sequence.ToString(), said["sequence"].Text, name);
                Check.Same(message.Id.ToString(), said["id"].Text, name);
                Check.Same(message.Flags, (int)said["flags"].Number, name);
                Check.Same(message.Count, said["points"].Items.Count, name);
                for (int i = 0; i < message.Count; i++) Point(name + ", point " + i, message.Points[i], said["points"].Items[i]);
                // No bit of it can be another.
                for (int i = 0; i < bytes.Length; i++)
                {
                    var damaged = (byte[])bytes.Clone();
                    damaged[i] ^= (byte)(1 << i % 8);
                    Check.Throws<FrameException>(() => message.Read(damaged, 0, damaged.Length, 2000), name + ", byte " + i);
                }
                Check.Throws<FrameException>(() => message.Read(bytes, 0, bytes.Length - 1, 2000), name + " cut");
                if (message.Count == 0) continue;
                Check.Throws<FrameException>(() => message.Read(bytes, 0, bytes.Length, message.Count - 1), name + ", too many");
            }
        }

        private static void Point(string where, Water got, JsonValue said)
        {
            float[] values =
            {
                got.Height, got.Jacobian, got.Residual, got.NormalX, got.NormalY, got.NormalZ, got.VelocityX,
                got.VelocityY, got.VelocityZ,
            };
            List<JsonValue> n = said["normal"].Items, v = said["velocity"].Items;
            JsonValue[] must = { said["height"], said["jacobian"], said["residual"], n[0], n[1], n[2], v[0], v[1], v[2] };
            for (int i = 0; i < values.Length; i++)
            {
                string value = values[i].ToString("R", CultureInfo.InvariantCulture);
                Check.That(values[i] == (float)must[i].Number, where + ", value " + i + " is " + value);
            }
            Check.Same(got.Folded, said["folded"].Boolean, where);
        }
    }
}
