// Textures of the fields of all cascades, for shaders: two of each, made when there is something to show.
using System;
using UnityEngine;

namespace Swellcast
{
    internal sealed class OceanTextures : IDisposable
    {
        private readonly Texture2D[] displacements, normals;
        private readonly bool half;
        private ushort[] halves = new ushort[0];

        public OceanTextures(int cascades, bool half)
        {
            displacements = new Texture2D[cascades];
            normals = new Texture2D[cascades];
            this.half = half;
        }

        public Texture2D Displacement(int cascade)
        {
            return displacements[cascade] != null ? displacements[cascade] : Texture2D.blackTexture;
        }

        public Texture2D Normals(int cascade)
        {
            return normals[cascade] != null ? normals[cascade] : Texture2D.blackTexture;
        }

        public void Upload(SeaFields fields)
        {
            for (int i = 0; i < displacements.Length; i++)
            {
                Upload(ref displacements[i], fields.Displacement(i), "Swellcast displacement " + i);
                Upload(ref normals[i], fields.Normals(i), "Swellcast normals " + i);
            }
        }

        private void Upload(ref Texture2D texture, SeaFields.Field field, string name)
        {
            if (texture != null && texture.width != field.Size) Drop(ref texture);
            if (field.Size == 0) return;
            if (texture == null)
            {
                TextureFormat format = half ? TextureFormat.RGBAHalf : TextureFormat.RGBAFloat;
                texture = new Texture2D(field.Size, field.Size, format, false, true)
                {
                    name = name,
                    wrapMode = TextureWrapMode.Repeat,
                    filterMode = FilterMode.Bilinear,
                };
            }
            if (half) texture.SetPixelData(Halved(field.Samples), 0);
            else texture.SetPixelData(field.Samples, 0);
            texture.Apply(false, false);
        }

        private ushort[] Halved(float[] samples)
        {
            if (halves.Length != samples.Length) halves = new ushort[samples.Length];
            for (int i = 0; i < samples.Length; i++) halves[i] = Mathf.FloatToHalf(samples[i]);
            return halves;
        }

        private static void Drop(ref Texture2D texture)
        {
            if (texture != null) UnityEngine.Object.Destroy(texture);
            texture = null;
        }

        public void Dispose()
        {
            for (int i = 0; i < displacements.Length; i++)
            {
                Drop(ref displacements[i]);
                Drop(ref normals[i]);
            }
        }
    }
}
