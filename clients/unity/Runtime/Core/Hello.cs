// `hello`: what sea this is and what can be had of it (PROTOCOL.md section 3).
using System.Collections.Generic;
using System.Globalization;

namespace Swellcast
{
    /// <summary>How fine and how often a group of a cascade can be had.</summary>
    public sealed class Detail
    {
        public string Group;
        public int FinestLevel;
        /// <summary>0: not at all; null: at any rate.</summary>
        public int? RateHz;
    }

    /// <summary>A square patch of water that repeats for ever.</summary>
    public sealed class Cascade
    {
        public int Index;
        public double PatchM;
        public int N, Levels;
        public double WavelengthMinM, WavelengthMaxM;
        public long FromTick;
        /// <summary>null while no change of layout ends it.</summary>
        public long? UntilTick;
        public Detail[] Details;

        /// <summary>Whether it is part of the sea at a tick.</summary>
        public bool IsThere(double tick)
        {
            return tick >= FromTick && (UntilTick == null || tick < UntilTick.Value);
        }

        /// <summary>Whether its last frames, which are nothing, are due: after them nothing has to come.</summary>
        public bool Rests(double tick)
        {
            return UntilTick != null && tick >= UntilTick.Value - Wire.RestTicks;
        }
    }

    /// <summary>The largest error that a class guarantees.</summary>
    public sealed class ErrorClass
    {
        public string Name;
        public double DisplacementM, Slope, Foam, VelocityMps;
    }

    public sealed class Hello
    {
        /// <summary>No server sends frames longer before their ticks.</summary>
        private const long LongestLead = 10 * Wire.TicksPerSecond;

        public string Server, Scene, Seed;
        /// <summary>The identity of this timeline.</summary>
        public ulong Epoch;
        public long Tick, LeadTicks, Sequence, Generation;
        public Cascade[] Cascades;
        public double Choppiness;
        public int[] RatesHz;
        public ErrorClass[] Classes;
        /// <summary>Names of the groups that this scene has.</summary>
        public string[] Groups;
        public int MessageBytes, MostUnits, MostPoints;

        internal static Hello Of(Fields f)
        {
            f.Whole("protocol", 1, 1);
            f.Whole("ticks_per_second", Wire.TicksPerSecond, Wire.TicksPerSecond);
            Fields layout = f.Object("layout"), limits = f.Object("limits");
            var hello = new Hello
            {
                Server = f.Text("server"),
                Scene = f.Text("scene"),
                Seed = f.Text("seed"),
                Epoch = EpochOf(f.Text("epoch")),
                Tick = f.Whole("tick", 0, Wire.MaxTick),
                LeadTicks = f.Whole("lead_ticks", 0, LongestLead),
                Sequence = f.Whole("sequence", 0, Wire.MaxTick),
                Generation = layout.Whole("generation", 0, Wire.MaxTick),
                Choppiness = f.Number("choppiness"),
                RatesHz = Rates(f),
                MessageBytes = (int)limits.Whole("message_bytes", 1, int.MaxValue),
                MostUnits = (int)limits.Whole("units", 0, int.MaxValue),
                MostPoints = limits.Has("points") ? (int)limits.Whole("points", 0, int.MaxValue) : 0,
            };
            Fields[] cascades = layout.Objects("cascades", 256), classes = f.Objects("classes", 256);
            Fields[] groups = f.Objects("groups", 256);
            hello.Cascades = new Cascade[cascades.Length];
            for (int i = 0; i < cascades.Length; i++) hello.Cascades[i] = CascadeOf(cascades[i]);
            hello.Classes = new ErrorClass[classes.Length];
            for (int i = 0; i < classes.Length; i++) hello.Classes[i] = ClassOf(classes[i]);
            hello.Groups = new string[groups.Length];
            for (int i = 0; i < groups.Length; i++) hello.Groups[i] = groups[i].Text("name");
            return hello;
        }

        /// <summary>A cascade by its index; null where there is none.</summary>
        public Cascade Find(int index)
        {
            foreach (Cascade cascade in Cascades)
            {
                if (cascade.Index == index) return cascade;
            }
            return null;
        }

        private static ulong EpochOf(string text)
        {
            ulong epoch;
            bool good = ulong.TryParse(text, NumberStyles.AllowHexSpecifier, CultureInfo.InvariantCulture, out epoch);
            if (good && text.Length == 16) return epoch;
            throw new MessageException("invalid", "epoch", "is \"" + text + "\", must be 16 hexadecimal digits");
        }

        private static int[] Rates(Fields f)
        {
            List<JsonValue> items = f.List("rates_hz");
            var rates = new int[items.Count];
            for (int i = 0; i < rates.Length; i++)
            {
                string path = "rates_hz[" + i + "]";
                if (!items[i].IsWhole(Wire.TicksPerSecond)) throw Fields.OfType(path, items[i], "1 to 7200");
                rates[i] = (int)items[i].Number;
                if (rates[i] == 0 || Wire.TicksPerSecond % rates[i] != 0)
                {
                    throw new MessageException("invalid", path, "is " + rates[i] + ", must divide 7200");
                }
            }
            if (rates.Length == 0) throw new MessageException("invalid", "rates_hz", "is empty, must hold a rate");
            return rates;
        }

        private static Cascade CascadeOf(Fields f)
        {
            var cascade = new Cascade
            {
                Index = (int)f.Whole("index", 0, 255),
                PatchM = f.Positive("patch_m"),
                N = (int)f.Whole("n", 8, 65535),
                Levels = (int)f.Whole("levels", 1, 16),
                WavelengthMinM = f.Positive("wavelength_min_m"),
                WavelengthMaxM = f.Positive("wavelength_max_m"),
                FromTick = f.Whole("from_tick", 0, Wire.MaxTick),
                UntilTick = f.Has("until_tick") ? f.Whole("until_tick", 0, Wire.MaxTick) : (long?)null,
                Details = new Detail[0],
            };
            if (!f.Has("detail")) return cascade;
            Fields[] details = f.Objects("detail", 256);
            cascade.Details = new Detail[details.Length];
            for (int i = 0; i < details.Length; i++)
            {
                Fields d = details[i];
                cascade.Details[i] = new Detail
                {
                    Group = d.Text("group"),
                    FinestLevel = d.Has("finest_level") ? (int)d.Whole("finest_level", 0, 255) : 0,
                    RateHz = d.Has("rate_hz") ? (int)d.Whole("rate_hz", 0, Wire.TicksPerSecond) : (int?)null,
                };
            }
            return cascade;
        }

        private static ErrorClass ClassOf(Fields f)
        {
            return new ErrorClass
            {
                Name = f.Text("name"),
                DisplacementM = f.Number("displacement_m"),
                Slope = f.Number("slope"),
                Foam = f.Number("foam"),
                VelocityMps = f.Number("velocity_mps"),
            };
        }
    }
}
