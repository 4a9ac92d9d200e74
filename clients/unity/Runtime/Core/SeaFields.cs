// The sea at one moment as arrays that a picture is made of: of each cascade displacement and foam, and what normals are
// made of, four numbers a sample, row by row; and their sum at a place. For one thread at a time.
using System;

namespace Swellcast
{
    /// <summary>The surface at the particle that rests at a place; axes are east, up, south.</summary>
    public struct SurfacePoint
    {
        /// <summary>Metres.</summary>
        public float DX, Height, DZ;
        /// <summary>0 to 1.</summary>
        public float Foam;
        /// <summary>Unit vector.</summary>
        public float NormalX, NormalY, NormalZ;
    }

    public sealed class SeaFields
    {
        /// <summary>
        /// One field of a cascade: `Size` x `Size` samples of four numbers; 0 where there is nothing.
        /// </summary>
        public sealed class Field
        {
            public int Size;
            public float[] Samples = new float[0];

            internal void Resize(int size)
            {
                if (Size == size) return;
                Size = size;
                Samples = new float[size * size * 4];
            }
        }

        private readonly Sea sea;
        private readonly Field[] displacements, normals;
        private readonly bool[] stretched;

        public SeaFields(Sea sea)
        {
            this.sea = sea;
            int count = sea.Cascades.Length;
            displacements = new Field[count];
            normals = new Field[count];
            stretched = new bool[count];
            for (int i = 0; i < count; i++)
            {
                displacements[i] = new Field();
                normals[i] = new Field();
            }
        }

        /// <summary>Cascades, in the order of the layout.</summary>
        public int Count { get { return displacements.Length; } }

        /// <summary>dx, height, dz in metres, and foam.</summary>
        public Field Displacement(int place)
        {
            return displacements[place];
        }

        /// <summary>
        /// normal_x, normal_z, 0, 0 where the group `normals` comes, else slope_x, slope_z, dxx, dzz. Either way the
        /// normal is that of the sums over cascades: (-x / (1 + dxx), 1, -z / (1 + dzz)), made a unit vector.
        /// </summary>
        public Field Normals(int place)
        {
            return normals[place];
        }

        /// <summary>Sets the sea, and the fields, to a moment.</summary>
        public void Seek(double tick)
        {
            sea.Seek(tick);
            for (int i = 0; i < displacements.Length; i++)
            {
                UpdateDisplacement(i);
                UpdateNormals(i);
            }
        }

        private void UpdateDisplacement(int place)
        {
            Field field = displacements[place];
            field.Resize(sea.SizeOf(place, Group.Displacement));
            if (field.Size == 0) return;
            for (int c = 0; c < 3; c++) Blend(field, place, Group.Displacement, c, c);
            if (!Blend(field, place, Group.Foam, 0, 3)) Zero(field, 3);
        }

        private void UpdateNormals(int place)
        {
            Field field = normals[place];
            int size = sea.SizeOf(place, Group.Normals);
            bool ready = size > 0;
            field.Resize(ready ? size : sea.SizeOf(place, Group.Slopes));
            if (field.Size == 0) return;
            for (int c = 0; c < 2; c++) Blend(field, place, ready ? Group.Normals : Group.Slopes, c, c);
            bool was = stretched[place];
            stretched[place] = !ready
                && (Stretch(field, place, Group.Stretch) || Stretch(field, place, Group.Derivatives));
            if (stretched[place] || !was) return;
            Zero(field, 2);
            Zero(field, 3);
        }

        private bool Stretch(Field field, int place, int group)
        {
            return Blend(field, place, group, 0, 2) && Blend(field, place, group, 1, 3);
        }

        private bool Blend(Field field, int place, int group, int channel, int first)
        {
            return sea.Blend(place, group, channel, field.Size, field.Samples, 4, first);
        }

        private static void Zero(Field field, int first)
        {
            for (int i = first; i < field.Samples.Length; i += 4) field.Samples[i] = 0;
        }

        /// <summary>The sum at an undisplaced place, metres to the east and to the south of the origin.</summary>
        public SurfacePoint At(double x0, double z0)
        {
            var point = new SurfacePoint();
            float bare = 1, slopeX = 0, slopeZ = 0, dxx = 0, dzz = 0;
            for (int i = 0; i < displacements.Length; i++)
            {
                double u = x0 / sea.Cascades[i].PatchM, v = z0 / sea.Cascades[i].PatchM;
                float a, b, c, d;
                Read(displacements[i], u, v, out a, out b, out c, out d);
                point.DX += a;
                point.Height += b;
                point.DZ += c;
                bare *= 1 - Math.Min(1, Math.Max(0, d));
                Read(normals[i], u, v, out a, out b, out c, out d);
                slopeX += a;
                slopeZ += b;
                dxx += c;
                dzz += d;
            }
            point.Foam = 1 - bare;
            // Where the surface folds there is no slope; it is drawn steep.
            float x = -slopeX / Math.Max(0.1f, 1 + dxx), z = -slopeZ / Math.Max(0.1f, 1 + dzz);
            float length = (float)Math.Sqrt(x * x + 1 + z * z);
            point.NormalX = x / length;
            point.NormalY = 1 / length;
            point.NormalZ = z / length;
            return point;
        }

        /// <summary>Linear between the four samples about a place, given in patches.</summary>
        private static void Read(Field field, double u, double v, out float a, out float b, out float c, out float d)
        {
            int n = field.Size;
            if (n == 0)
            {
                a = b = c = d = 0;
                return;
            }
            int x0, x1, z0, z1;
            float fx = UnitFrames.Between(u, n, out x0, out x1), fz = UnitFrames.Between(v, n, out z0, out z1);
            float w00 = (1 - fx) * (1 - fz), w10 = fx * (1 - fz), w01 = (1 - fx) * fz, w11 = fx * fz;
            float[] s = field.Samples;
            int p00 = (z0 * n + x0) * 4, p10 = (z0 * n + x1) * 4, p01 = (z1 * n + x0) * 4, p11 = (z1 * n + x1) * 4;
            a = w00 * s[p00] + w10 * s[p10] + w01 * s[p01] + w11 * s[p11];
            b = w00 * s[p00 + 1] + w10 * s[p10 + 1] + w01 * s[p01 + 1] + w11 * s[p11 + 1];
            c = w00 * s[p00 + 2] + w10 * s[p10 + 2] + w01 * s[p01 + 2] + w11 * s[p11 + 2];
            d = w00 * s[p00 + 3] + w10 * s[p10 + 3] + w01 * s[p01 + 3] + w11 * s[p11 + 3];
        }
    }
}
