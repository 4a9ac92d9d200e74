// Writes JSON: objects and lists are opened and closed by hand, commas come by themselves.
using System;
using System.Globalization;
using System.Text;

namespace Swellcast
{
    public sealed class JsonWriter
    {
        private readonly StringBuilder text = new StringBuilder();
        private bool first = true;

        public override string ToString()
        {
            return text.ToString();
        }

        public JsonWriter Open(char bracket)
        {
            Comma();
            text.Append(bracket);
            first = true;
            return this;
        }

        public JsonWriter Close(char bracket)
        {
            text.Append(bracket);
            first = false;
            return this;
        }

        /// <summary>The name of the value that is written next.</summary>
        public JsonWriter Name(string name)
        {
            Comma();
            Quote(name);
            text.Append(':');
            first = true;
            return this;
        }

        public JsonWriter Value(string value)
        {
            Comma();
            Quote(value);
            return this;
        }

        public JsonWriter Value(long value)
        {
            Comma();
            text.Append(value.ToString(CultureInfo.InvariantCulture));
            return this;
        }

        /// <exception cref="ArgumentException">JSON has no such number.</exception>
        public JsonWriter Value(double value)
        {
            if (!Wire.IsFinite(value)) throw new ArgumentException("number is " + value + ", must be finite");
            Comma();
            text.Append(value.ToString("R", CultureInfo.InvariantCulture));
            return this;
        }

        public JsonWriter Value(bool value)
        {
            Comma();
            text.Append(value ? "true" : "false");
            return this;
        }

        private void Comma()
        {
            if (!first) text.Append(',');
            first = false;
        }

        private void Quote(string value)
        {
            text.Append('"');
            foreach (char letter in value)
            {
                if (letter == '"' || letter == '\\') text.Append('\\').Append(letter);
                else if (letter < ' ') text.Append("\\u").Append(((int)letter).ToString("x4"));
                else text.Append(letter);
            }
            text.Append('"');
        }
    }
}
