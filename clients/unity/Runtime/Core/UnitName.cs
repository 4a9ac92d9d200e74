// A unit: what the server encodes and sends once for all (PROTOCOL.md section 4).
namespace Swellcast
{
    public sealed class UnitName
    {
        /// <summary>`index` of a cascade of `hello`.</summary>
        public int Cascade;
        /// <summary>0 is the full grid, each further level halves it.</summary>
        public int Level;
        public string Class, Group, Codec = "i16";
        /// <summary>Frames a second; 0: the subscription's.</summary>
        public int RateHz;

        /// <summary>
        /// Reads one as a server grants it: names that are not known stand for frames that never come.
        /// </summary>
        internal static UnitName Of(Fields f)
        {
            return new UnitName
            {
                Cascade = (int)f.Whole("cascade", 0, 255),
                Level = (int)f.Whole("level", 0, 255),
                Class = f.Text("class"),
                Group = f.Text("group"),
                Codec = f.Has("codec") ? f.Text("codec") : "i16",
                RateHz = f.Has("rate_hz") ? (int)f.Whole("rate_hz", 0, Wire.TicksPerSecond) : 0,
            };
        }

        internal void Write(JsonWriter json)
        {
            json.Open('{').Name("cascade").Value(Cascade).Name("level").Value(Level).Name("class").Value(Class);
            json.Name("group").Value(Group).Name("codec").Value(Codec);
            if (RateHz > 0) json.Name("rate_hz").Value(RateHz);
            json.Close('}');
        }

        public override string ToString()
        {
            return Group + " of cascade " + Cascade + ", level " + Level + ", " + Class + ", " + Codec;
        }
    }
}
