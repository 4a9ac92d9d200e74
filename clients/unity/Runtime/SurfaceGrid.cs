// The vertices of a surface, computed on any thread: nothing here touches an object of the engine.
using UnityEngine;

namespace Swellcast
{
    internal sealed class SurfaceGrid
    {
        public readonly int Cells;
        public readonly float Metres;
        public readonly Vector3[] Vertices, Normals;
        /// <summary>White, with foam as alpha.</summary>
        public readonly Color[] Colours;
        /// <summary>The corner with the least x and z, metres from the object.</summary>
        public float Left, Near;

        public SurfaceGrid(int cells, float metres)
        {
            Cells = cells;
            Metres = metres;
            int side = cells + 1;
            Vertices = new Vector3[side * side];
            Normals = new Vector3[side * side];
            Colours = new Color[side * side];
            for (int i = 0; i < Colours.Length; i++) Colours[i] = new Color(1, 1, 1, 0);
        }

        /// <summary>Puts the grid about a place, in steps of whole cells: the water under it doesn't swim.</summary>
        public void Centre(Vector3 place)
        {
            float cell = Metres / Cells;
            Left = Mathf.Round(place.x / cell) * cell - Metres / 2;
            Near = Mathf.Round(place.z / cell) * cell - Metres / 2;
        }

        public void Displace(SeaFields fields)
        {
            float cell = Metres / Cells;
            for (int row = 0, i = 0; row <= Cells; row++)
            {
                float z = Near + row * cell;
                for (int column = 0; column <= Cells; column++, i++)
                {
                    float x = Left + column * cell;
                    SurfacePoint at = fields.At(x, -z); // the sea's z is to the south
                    Vertices[i] = new Vector3(x + at.DX, at.Height, z - at.DZ);
                    Normals[i] = new Vector3(at.NormalX, at.NormalY, -at.NormalZ);
                    Colours[i].a = at.Foam;
                }
            }
        }

        /// <summary>Two for each cell, clockwise as seen from above.</summary>
        public int[] Triangles()
        {
            var triangles = new int[Cells * Cells * 6];
            for (int cell = 0, at = 0; cell < Cells * Cells; cell++, at += 6)
            {
                int corner = cell / Cells * (Cells + 1) + cell % Cells;
                triangles[at] = corner;
                triangles[at + 1] = triangles[at + 4] = corner + Cells + 1;
                triangles[at + 2] = triangles[at + 3] = corner + 1;
                triangles[at + 5] = corner + Cells + 2;
            }
            return triangles;
        }
    }
}
