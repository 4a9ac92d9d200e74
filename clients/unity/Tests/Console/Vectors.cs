// The vectors of the repository, as files and as JSON.
using System;
using System.Collections.Generic;
using System.IO;

namespace Swellcast.Tests
{
    internal static class Vectors
    {
        public static string Folder;

        public static string[] Files(string folder, string ending)
        {
            string[] files = Directory.GetFiles(Path.Combine(Folder, folder), "*" + ending);
            Check.That(files.Length > 0, "there are files " + folder + "*" + ending);
            Array.Sort(files, StringComparer.Ordinal);
            return files;
        }

        public static JsonValue Json(string name)
        {
            return JsonReader.Read(File.ReadAllText(Path.Combine(Folder, name)), 1 << 24);
        }

        public static byte[] Bytes(string name)
        {
            return File.ReadAllBytes(Path.Combine(Folder, name));
        }

        /// <summary>Frames of a file, each after its length, a u32.</summary>
        public static List<byte[]> Split(byte[] bytes)
        {
            var frames = new List<byte[]>();
            for (int at = 0; at < bytes.Length;)
            {
                var frame = new byte[Wire.U32(bytes, at)];
                Array.Copy(bytes, at + 4, frame, 0, frame.Length);
                frames.Add(frame);
                at += 4 + frame.Length;
            }
            return frames;
        }
    }
}
