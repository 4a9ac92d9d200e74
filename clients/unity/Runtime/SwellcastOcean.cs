// The ocean of a server in a scene: connects, keeps its time, and sets textures and a surface to the water of the moment.
// The numbers are made on another thread, for the moment at which they will be shown; where that takes longer than a
// picture, the water moves less often and nothing waits.
//
// Axes: Swellcast's world is right-handed, x east, y up, z south; Unity's is left-handed. Here x is east, y up and z
// north, so z changes sign on the way. The object's position is the sea's origin; it is neither turned nor scaled.
using System;
using UnityEngine;

namespace Swellcast
{
    [AddComponentMenu("Swellcast/Ocean")]
    [DisallowMultipleComponent]
    public sealed class SwellcastOcean : MonoBehaviour
    {
        [Tooltip("Address of the server, like http://127.0.0.1:8080")]
        [SerializeField] private string url = "http://127.0.0.1:8080";
        [Tooltip("Groups of channels, in order of need; those that the scene doesn't have are left out")]
        [SerializeField] private string[] groups = { "displacement", "normals", "foam" };
        [Tooltip("Frames a second: 15, 30 or 60. Between them it is interpolated")]
        [SerializeField] private int rateHz = 15;
        [Tooltip("Largest error: 0.5mm, 1mm, 5mm or 20mm")]
        [SerializeField] private string errorClass = "1mm";
        [Tooltip("Level of detail: 0 is the full grid, each further one halves it")]
        [SerializeField] private int level;
        [Tooltip("Textures of displacement and of what normals are made of, for shaders")]
        [SerializeField] private bool textures = true;
        [Tooltip("16-bit floats in textures: half the memory, errors of 0.05 %")]
        [SerializeField] private bool halfTextures;
        [Tooltip("A grid that is displaced on the CPU; may be left empty")]
        [SerializeField] private SwellcastSurface surface;

        private OceanListener listener;
        private Connection connection;
        private Sea shown;
        private SeaFields fields;
        private OceanTextures pictures;
        private readonly Background background = new Background();
        private SurfaceGrid grid; // being displaced
        private double begun = double.NaN, moment; // ticks: when work began, and what moment it is for
        private long nextNews;
        private double span; // ticks from the beginning of work to when it is shown

        /// <summary>Address of the server. It and what is asked for take effect when the component is enabled.</summary>
        public string Url
        {
            get { return url; }
            set { url = value; }
        }

        /// <summary>Groups of channels, in order of need.</summary>
        public string[] Groups
        {
            get { return groups; }
            set { groups = value; }
        }

        /// <summary>Frames a second.</summary>
        public int RateHz
        {
            get { return rateHz; }
            set { rateHz = value; }
        }

        /// <summary>Name of an error class.</summary>
        public string ErrorClass
        {
            get { return errorClass; }
            set { errorClass = value; }
        }

        /// <summary>Level of detail; 0 is the finest.</summary>
        public int Level
        {
            get { return level; }
            set { level = value; }
        }

        /// <summary>A grid that is displaced on the CPU.</summary>
        public SwellcastSurface Surface
        {
            get { return surface; }
            set { surface = value; }
        }

        public bool Connected
        {
            get { return listener != null && listener.Connected; }
        }

        /// <summary>Whether there is water to show.</summary>
        public bool Ready
        {
            get { return shown != null && shown.Footing != Footing.Nothing; }
        }

        /// <summary>The moment that is shown, in ticks of the server; NaN before there is any.</summary>
        public double Tick { get; private set; } = double.NaN;

        /// <summary>Cascades whose textures are summed; changes with the server's layout.</summary>
        public int CascadeCount
        {
            get { return shown == null ? 0 : shown.Cascades.Length; }
        }

        /// <summary>Side of a cascade's patch, metres: its textures repeat after that.</summary>
        public float PatchMetres(int cascade)
        {
            return (float)shown.Cascades[cascade].PatchM;
        }

        /// <summary>
        /// dx, height, dz (metres; east, up, south) and foam of a cascade; black where it has nothing to show.
        /// Texel (i, j) is the sample at x0 = i / n, z0 = j / n patches, z0 to the south.
        /// </summary>
        public Texture2D Displacement(int cascade)
        {
            return pictures == null ? null : pictures.Displacement(cascade);
        }

        /// <summary>What normals are made of; see `SeaFields.Normals`.</summary>
        public Texture2D NormalData(int cascade)
        {
            return pictures == null ? null : pictures.Normals(cascade);
        }

        /// <summary>
        /// The height of the water in the world at a place of the world; the rest height before there is any.
        /// </summary>
        public float HeightAt(float x, float z)
        {
            Vector3 origin = transform.position;
            if (shown == null) return origin.y;
            return origin.y + shown.HeightAt(x - origin.x, origin.z - z);
        }

        /// <summary>At the first update, not sooner: who adds the component by script sets its address after that.</summary>
        private void Open()
        {
            listener = new OceanListener();
            var wish = new Wish { Groups = groups, RateHz = rateHz, Class = errorClass, Level = level };
            try
            {
                connection = new Connection(url, wish, listener);
            }
            catch (ArgumentException error)
            {
                Debug.LogError("Swellcast: " + error.Message, this);
                enabled = false;
            }
        }

        private void OnDisable()
        {
            if (connection != null) connection.Dispose();
            connection = null;
            // What is under way goes to fields that nobody shows any more.
            Show(null);
            begun = double.NaN;
            Tick = double.NaN;
        }

        private void Update()
        {
            if (connection == null) Open();
            if (connection == null) return;
            TellNews();
            double now = connection.Ticks;
            if (double.IsNaN(now) || !background.Idle) return;
            if (!double.IsNaN(begun)) Finish(now);
            Sea sea = listener.Sea;
            if (sea != shown) Show(sea);
            if (shown == null) return;
            begun = now;
            moment = now + span;
            grid = surface == null ? null : surface.Next();
            background.Start(Compute);
        }

        /// <summary>What there is to say, once a second at most: a server can't fill the log.</summary>
        private void TellNews()
        {
            long at = Connection.NowUs();
            if (at < nextNews) return;
            nextNews = at + 1000000;
            string news = listener.TakeNews();
            if (news != null) Debug.Log("Swellcast: " + news, this);
            Exception failure = listener.TakeFailure();
            if (failure != null) Debug.LogException(failure, this);
        }

        /// <summary>On another thread.</summary>
        private void Compute()
        {
            SeaFields of = fields;
            SurfaceGrid displaced = grid;
            if (of == null) return; // disabled meanwhile
            of.Seek(moment);
            if (displaced != null) displaced.Displace(of);
        }

        /// <summary>Shows what was computed.</summary>
        private void Finish(double now)
        {
            // Not to be led astray by a stop: what usually passes, and never more than a tenth of a second.
            span += (Math.Min(Math.Max(0, now - begun), 720) - span) / 8;
            begun = double.NaN;
            Exception error = background.TakeError();
            if (error != null) Debug.LogException(error, this);
            if (error != null || shown == null) return;
            Tick = moment;
            if (pictures != null) pictures.Upload(fields);
            if (surface != null && grid != null) surface.Show(grid);
        }

        /// <summary>Another sea, or another layout of it.</summary>
        private void Show(Sea sea)
        {
            if (pictures != null) pictures.Dispose();
            shown = sea;
            fields = sea == null ? null : new SeaFields(sea);
            pictures = sea == null || !textures ? null : new OceanTextures(sea.Cascades.Length, halfTextures);
        }
    }
}
