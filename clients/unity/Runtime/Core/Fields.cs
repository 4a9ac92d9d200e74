// Looks into a message field by field: what is not as it must be is refused by its path, its value and its bound.
using System;
using System.Collections.Generic;
using System.Globalization;

namespace Swellcast
{
    /// <summary>A text message that can't be used, from a server or to one.</summary>
    public sealed class MessageException : Exception
    {
        /// <summary>
        /// `malformed`, `unknown_type` or `invalid`, as a server's `error` says (PROTOCOL.md section 3).
        /// </summary>
        public readonly string Code;
        /// <summary>The path of the field at fault, like `units[2].class`; null for none.</summary>
        public readonly string Field;

        public MessageException(string code, string field, string why) : base(field == null ? why : field + " " + why)
        {
            Code = code;
            Field = field;
        }
    }

    /// <summary>The fields of one object of a message.</summary>
    internal struct Fields
    {
        private readonly JsonValue value;
        private readonly string path;

        public Fields(JsonValue value, string path)
        {
            if (value.Kind != JsonKind.Object) throw OfType(path, value, "an object");
            this.value = value;
            this.path = path.Length > 0 ? path + "." : path;
        }

        /// <summary>Reads a text; what is no JSON, or no object with a `type`, is refused.</summary>
        public static Fields Read(string text, int mostLength, out string type)
        {
            JsonValue value;
            try
            {
                value = JsonReader.Read(text, mostLength);
            }
            catch (JsonException error)
            {
                string why = error.Field == null ? error.Message : "stands twice, must stand once";
                throw new MessageException("malformed", error.Field, why);
            }
            if (value.Kind != JsonKind.Object)
            {
                throw new MessageException("malformed", null, "message is " + Shown(value) + ", must be an object");
            }
            var fields = new Fields(value, "");
            type = fields.Text("type");
            return fields;
        }

        public string PathOf(string name)
        {
            return path + name;
        }

        /// <summary>Refuses fields that are not in the list.</summary>
        public void Only(params string[] names)
        {
            foreach (string name in value.Names)
            {
                if (Array.IndexOf(names, name) >= 0) continue;
                throw new MessageException("malformed", path + name, "is not known");
            }
        }

        /// <summary>Whether a field is there, and not null.</summary>
        public bool Has(string name)
        {
            JsonValue field = value[name];
            return field != null && field.Kind != JsonKind.Null;
        }

        /// <summary>Whether a field is there, be it null.</summary>
        public bool Names(string name)
        {
            return value[name] != null;
        }

        public string Text(string name)
        {
            return Of(name, JsonKind.Text, "a string").Text;
        }

        public bool Boolean(string name)
        {
            return Of(name, JsonKind.Boolean, "a boolean").Boolean;
        }

        public double Number(string name)
        {
            return Of(name, JsonKind.Number, "a number").Number;
        }

        /// <summary>A number above 0.</summary>
        public double Positive(string name)
        {
            double number = Number(name);
            if (number > 0) return number;
            throw OutOfBounds(name, "above 0");
        }

        /// <summary>A whole number within bounds.</summary>
        public long Whole(string name, long least, long most)
        {
            double number = Number(name);
            if (number >= least && number <= most && number == Math.Floor(number)) return (long)number;
            throw OutOfBounds(name, "a whole number from " + least + " to " + most);
        }

        /// <summary>One of some names; its index.</summary>
        public int OneOf(string name, string[] names)
        {
            int index = Array.IndexOf(names, Text(name));
            if (index >= 0) return index;
            throw OutOfBounds(name, "one of " + string.Join(", ", names));
        }

        public Fields Object(string name)
        {
            return new Fields(Of(name, JsonKind.Object, "an object"), path + name);
        }

        public List<JsonValue> List(string name)
        {
            return Of(name, JsonKind.List, "an array").Items;
        }

        /// <summary>A list of objects; null ones too are refused by their path.</summary>
        public Fields[] Objects(string name, int most)
        {
            List<JsonValue> items = List(name);
            if (items.Count > most)
            {
                string why = "has " + items.Count + " elements, must have at most " + most;
                throw new MessageException("invalid", path + name, why);
            }
            var objects = new Fields[items.Count];
            for (int i = 0; i < objects.Length; i++) objects[i] = new Fields(items[i], path + name + "[" + i + "]");
            return objects;
        }

        private JsonValue Of(string name, JsonKind kind, string called)
        {
            JsonValue field = value[name];
            if (field == null) throw new MessageException("malformed", path + name, "is not there, must be " + called);
            if (field.Kind != kind) throw OfType(path + name, field, called);
            return field;
        }

        private MessageException OutOfBounds(string name, string must)
        {
            return new MessageException("invalid", path + name, "is " + Shown(value[name]) + ", must be " + must);
        }

        public static MessageException OfType(string path, JsonValue found, string must)
        {
            return new MessageException("malformed", path, "is " + Shown(found) + ", must be " + must);
        }

        private static string Shown(JsonValue value)
        {
            switch (value.Kind)
            {
                case JsonKind.Null: return "null";
                case JsonKind.Boolean: return value.Boolean ? "true" : "false";
                case JsonKind.Number: return value.Number.ToString("R", CultureInfo.InvariantCulture);
                case JsonKind.Text: return "\"" + (value.Text.Length > 40 ? value.Text.Substring(0, 40) : value.Text) + "\"";
                case JsonKind.List: return "an array";
                default: return "an object";
            }
        }
    }
}
