// The names of classes, groups and codecs, by the numbers that frames have for them.
using System;

namespace Swellcast
{
    /// <summary>Classes, groups and codecs: a name's index is its number on the wire.</summary>
    public static class Names
    {
        public static readonly string[] Classes = { "0.5mm", "1mm", "5mm", "20mm" };
        public static readonly string[] Groups =
        {
            "displacement", "slopes", "derivatives", "foam", "height", "velocity", "jacobian", "stretch", "normals",
        };
        /// <summary>Channels of each group.</summary>
        public static readonly int[] GroupChannels = { 3, 2, 3, 1, 1, 3, 2, 2, 2 };
        public static readonly string[] Codecs = { "i16", "rans", "deflate", "f16", "f32" };

        /// <summary>The number of a name, -1 for one that is not known.</summary>
        public static int IndexOf(string[] names, string name)
        {
            return Array.IndexOf(names, name);
        }
    }

    /// <summary>Numbers of codecs.</summary>
    public static class Codec
    {
        public const int I16 = 0, Rans = 1, Deflate = 2, F16 = 3, F32 = 4;

        /// <summary>Whether its frames may be predicted from others.</summary>
        public static bool Predicts(int codec)
        {
            return codec == Rans || codec == Deflate;
        }

        /// <summary>Whether its frames hold counts; the others hold floats.</summary>
        public static bool IsCounts(int codec)
        {
            return codec <= Deflate;
        }
    }

    /// <summary>Numbers of groups.</summary>
    public static class Group
    {
        public const int Displacement = 0, Slopes = 1, Derivatives = 2, Foam = 3, Height = 4, Velocity = 5;
        public const int Jacobian = 6, Stretch = 7, Normals = 8;
    }
}
