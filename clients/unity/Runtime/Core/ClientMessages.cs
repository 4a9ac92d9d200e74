// Text messages to the server (PROTOCOL.md section 4): writes them, and checks them by the rules that the server has.
using System.Collections.Generic;

namespace Swellcast
{
    public static class ClientMessages
    {
        /// <summary>Points lie within so many metres of the origin.</summary>
        public const double MostMetres = 1e9;
        private const long MostId = Wire.MaxTick;

        public static string Subscribe(long id, int rateHz, IList<UnitName> units, bool keys)
        {
            JsonWriter json = Begin("subscribe").Name("id").Value(id).Name("rate_hz").Value(rateHz);
            json.Name("units").Open('[');
            foreach (UnitName unit in units) unit.Write(json);
            json.Close(']');
            if (keys) json.Name("keys").Value(true);
            return json.Close('}').ToString();
        }

        /// <summary>Asks for the water at points; `xz` holds x and z of each in turn, metres.</summary>
        public static string Points(long id, int rateHz, double[] xz)
        {
            JsonWriter json = Begin("points").Name("id").Value(id).Name("rate_hz").Value(rateHz);
            json.Name("points").Open('[');
            for (int i = 0; i + 1 < xz.Length; i += 2) json.Open('[').Value(xz[i]).Value(xz[i + 1]).Close(']');
            return json.Close(']').Close('}').ToString();
        }

        public static string Report(long tick, double decodeMs, double bufferMs, bool lost)
        {
            JsonWriter json = Begin("report").Name("tick").Value(tick);
            json.Name("decode_ms").Value(decodeMs).Name("buffer_ms").Value(bufferMs);
            if (lost) json.Name("lost").Value(true);
            return json.Close('}').ToString();
        }

        public static string Time(long t0)
        {
            return Begin("time").Name("t0").Value(t0).Close('}').ToString();
        }

        private static JsonWriter Begin(string type)
        {
            return new JsonWriter().Open('{').Name("type").Value(type);
        }

        /// <summary>Refuses what every server would refuse, before it is sent.</summary>
        /// <exception cref="MessageException">Names field, value and bound.</exception>
        public static void Check(string text, int messageBytes)
        {
            string type;
            // Characters are no more than bytes: who writes names of this protocol alone has one byte for each.
            Fields f = Fields.Read(text, messageBytes, out type);
            switch (type)
            {
                case "subscribe":
                    CheckSubscribe(f);
                    break;
                case "points":
                    CheckPoints(f);
                    break;
                case "report":
                    f.Only("type", "tick", "decode_ms", "buffer_ms", "lost");
                    f.Whole("tick", 0, Wire.MaxTick);
                    f.Number("decode_ms");
                    f.Number("buffer_ms");
                    if (f.Names("lost")) f.Boolean("lost");
                    break;
                case "time":
                    f.Only("type", "t0");
                    f.Number("t0");
                    break;
                default:
                    throw new MessageException("unknown_type", "type", "is \"" + type + "\", no message from a client");
            }
        }

        private static void CheckSubscribe(Fields f)
        {
            f.Only("type", "id", "rate_hz", "keys", "units");
            f.Whole("id", 0, MostId);
            f.Whole("rate_hz", 0, uint.MaxValue);
            if (f.Names("keys")) f.Boolean("keys");
            foreach (Fields unit in f.Objects("units", int.MaxValue))
            {
                unit.Only("cascade", "level", "class", "group", "codec", "rate_hz");
                unit.Whole("cascade", 0, 255);
                unit.Whole("level", 0, 255);
                unit.OneOf("class", Names.Classes);
                unit.OneOf("group", Names.Groups);
                if (unit.Names("codec")) unit.OneOf("codec", Names.Codecs);
                if (unit.Names("rate_hz")) unit.Whole("rate_hz", 0, uint.MaxValue);
            }
        }

        private static void CheckPoints(Fields f)
        {
            f.Only("type", "id", "rate_hz", "points");
            f.Whole("id", 0, MostId);
            f.Whole("rate_hz", 0, uint.MaxValue);
            List<JsonValue> points = f.List("points");
            for (int i = 0; i < points.Count; i++)
            {
                string path = f.PathOf("points") + "[" + i + "]";
                if (points[i].Kind != JsonKind.List || points[i].Items.Count != 2)
                {
                    throw Fields.OfType(path, points[i], "an array of two numbers");
                }
                for (int axis = 0; axis < 2; axis++)
                {
                    JsonValue metres = points[i].Items[axis];
                    string of = path + "[" + axis + "]";
                    if (metres.Kind != JsonKind.Number) throw Fields.OfType(of, metres, "a number");
                    if (metres.Number >= -MostMetres && metres.Number <= MostMetres) continue;
                    throw new MessageException("invalid", of, "is " + metres.Number + ", must be within 1e9 of 0");
                }
            }
        }
    }
}
