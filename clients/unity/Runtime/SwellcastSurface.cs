// A square grid that is displaced on the CPU: for any material and any render pipeline. It may follow an object.
using UnityEngine;
using UnityEngine.Rendering;

namespace Swellcast
{
    [AddComponentMenu("Swellcast/Surface")]
    [RequireComponent(typeof(MeshFilter), typeof(MeshRenderer))]
    public sealed class SwellcastSurface : MonoBehaviour
    {
        private const float HighestWave = 50;

        [Tooltip("Cells a side, 1 to 1024")]
        [SerializeField] private int cells = 128;
        [Tooltip("Metres a side")]
        [SerializeField] private float metres = 200;
        [Tooltip("The grid stays about this object; may be left empty")]
        [SerializeField] private Transform follow;

        private SurfaceGrid grid;
        private Mesh mesh;

        /// <summary>Cells a side; takes effect at the next moment that is shown.</summary>
        public int Cells
        {
            get { return cells; }
            set { cells = value; }
        }

        /// <summary>Metres a side; takes effect at the next moment that is shown.</summary>
        public float Metres
        {
            get { return metres; }
            set { metres = value; }
        }

        /// <summary>The grid stays about this object.</summary>
        public Transform Follow
        {
            get { return follow; }
            set { follow = value; }
        }

        /// <summary>The grid to be displaced next, about its place.</summary>
        internal SurfaceGrid Next()
        {
            int side = Mathf.Clamp(cells, 1, 1024);
            if (grid == null || grid.Cells != side || grid.Metres != metres) grid = new SurfaceGrid(side, metres);
            grid.Centre(follow == null ? Vector3.zero : follow.position - transform.position);
            return grid;
        }

        /// <summary>Shows a grid that was displaced; foam is the alpha of its colours.</summary>
        internal void Show(SurfaceGrid displaced)
        {
            if (mesh == null)
            {
                mesh = new Mesh { name = "Swellcast surface", indexFormat = IndexFormat.UInt32 };
                mesh.MarkDynamic();
                GetComponent<MeshFilter>().sharedMesh = mesh;
            }
            bool other = mesh.vertexCount != displaced.Vertices.Length;
            if (other) mesh.Clear();
            mesh.vertices = displaced.Vertices;
            mesh.normals = displaced.Normals;
            mesh.colors = displaced.Colours;
            if (other) mesh.triangles = displaced.Triangles();
            float half = displaced.Metres / 2, size = displaced.Metres + 2 * HighestWave;
            var middle = new Vector3(displaced.Left + half, 0, displaced.Near + half);
            mesh.bounds = new Bounds(middle, new Vector3(size, 2 * HighestWave, size));
        }

        private void OnDestroy()
        {
            if (mesh != null) Destroy(mesh);
        }
    }
}
