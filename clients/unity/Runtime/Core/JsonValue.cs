// A JSON value that was read. Looking for what is not there gives null, so that a message is checked field by field.
using System.Collections.Generic;

namespace Swellcast
{
    public enum JsonKind
    {
        Null,
        Boolean,
        Number,
        Text,
        List,
        Object,
    }

    public sealed class JsonValue
    {
        public static readonly JsonValue Null = new JsonValue();

        public JsonKind Kind;
        public bool Boolean;
        public double Number;
        public string Text;
        /// <summary>Of a list its values; of an object those of its fields, in order.</summary>
        public List<JsonValue> Items;
        /// <summary>Of an object the names of its fields, in order.</summary>
        public List<string> Names;

        /// <summary>A field of an object; null where there is none, or no object.</summary>
        public JsonValue this[string name]
        {
            get
            {
                int at = Kind == JsonKind.Object ? Names.IndexOf(name) : -1;
                return at < 0 ? null : Items[at];
            }
        }

        /// <summary>Whether it is a whole number from 0 to `most`.</summary>
        public bool IsWhole(long most)
        {
            return Kind == JsonKind.Number && Number >= 0 && Number <= most && Number == System.Math.Floor(Number);
        }
    }
}
