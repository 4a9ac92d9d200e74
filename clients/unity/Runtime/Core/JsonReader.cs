// Reads JSON (RFC 8259), strictly, with bounds on depth and length; a field that stands twice is refused, too, since
// readers would differ in which of the two they take.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Text;

namespace Swellcast
{
    /// <summary>A text that is not JSON.</summary>
    public sealed class JsonException : Exception
    {
        /// <summary>The path of the field that stands twice, else null.</summary>
        public readonly string Field;

        public JsonException(string why, string field = null) : base(why)
        {
            Field = field;
        }
    }

    public sealed class JsonReader
    {
        public const int MostDepth = 32;
        private readonly StringBuilder letters = new StringBuilder();
        private readonly string[] path = new string[MostDepth + 1];
        private string text;
        private int at, depth;

        /// <exception cref="JsonException">The text is no JSON, or beyond the bounds.</exception>
        public static JsonValue Read(string text, int mostLength)
        {
            if (text.Length > mostLength)
            {
                throw new JsonException("text has " + text.Length + " characters, must have at most " + mostLength);
            }
            var reader = new JsonReader { text = text };
            JsonValue value = reader.Value();
            reader.Space();
            if (reader.at < text.Length) throw reader.Wrong("nothing more");
            return value;
        }

        private JsonException Wrong(string expected)
        {
            string found = at < text.Length ? "character " + (int)text[at] : "the end";
            return new JsonException("text at " + at + " has " + found + ", must have " + expected);
        }

        private void Space()
        {
            while (at < text.Length && " \t\r\n".IndexOf(text[at]) >= 0) at++;
        }

        /// <summary>The next character that is no white space; '\0' at the end, which is no JSON either.</summary>
        private char Peek()
        {
            Space();
            return at < text.Length ? text[at] : '\0';
        }

        private void Expect(char character)
        {
            if (Peek() != character) throw Wrong("'" + character + "'");
            at++;
        }

        private JsonValue Value()
        {
            switch (Peek())
            {
                case '{': return Nested(true);
                case '[': return Nested(false);
                case '"': return new JsonValue { Kind = JsonKind.Text, Text = Text() };
                case 't': return Word("true", new JsonValue { Kind = JsonKind.Boolean, Boolean = true });
                case 'f': return Word("false", new JsonValue { Kind = JsonKind.Boolean });
                case 'n': return Word("null", JsonValue.Null);
                default: return new JsonValue { Kind = JsonKind.Number, Number = Number() };
            }
        }

        private JsonValue Word(string word, JsonValue value)
        {
            if (string.CompareOrdinal(text, at, word, 0, word.Length) != 0) throw Wrong("a value");
            at += word.Length;
            return value;
        }

        private JsonValue Nested(bool isObject)
        {
            if (++depth > MostDepth) throw new JsonException("text is nested deeper than " + MostDepth);
            var value = new JsonValue { Kind = isObject ? JsonKind.Object : JsonKind.List, Items = new List<JsonValue>() };
            char close = isObject ? '}' : ']';
            if (isObject) value.Names = new List<string>();
            at++;
            bool empty = Peek() == close;
            if (empty) at++;
            while (!empty)
            {
                if (isObject) Name(value);
                else path[depth] = "[" + value.Items.Count + "]";
                value.Items.Add(Value());
                if (Peek() == close) break;
                Expect(',');
            }
            if (!empty) at++;
            depth--;
            return value;
        }

        private void Name(JsonValue value)
        {
            if (Peek() != '"') throw Wrong("a name");
            string name = Text();
            path[depth] = depth > 1 ? "." + name : name;
            if (value.Names.Contains(name))
            {
                string field = string.Join("", path, 1, depth);
                throw new JsonException(field + " stands twice, must stand once", field);
            }
            value.Names.Add(name);
            Expect(':');
        }

        private string Text()
        {
            letters.Length = 0;
            at++;
            for (;;)
            {
                if (at == text.Length) throw Wrong("'\"'");
                char letter = text[at];
                if (letter < ' ') throw Wrong("no control character");
                at++;
                if (letter == '"') break;
                letters.Append(letter == '\\' ? Escaped() : letter);
            }
            string whole = letters.ToString();
            for (int i = 0; i < whole.Length; i++)
            {
                if (!char.IsSurrogate(whole[i])) continue;
                bool pair = i + 1 < whole.Length && char.IsSurrogatePair(whole[i], whole[i + 1]);
                if (!pair) throw new JsonException("text has half of a surrogate pair");
                i++;
            }
            return whole;
        }

        private char Escaped()
        {
            const string names = "\"\\/bfnrt", meanings = "\"\\/\b\f\n\r\t";
            char name = at < text.Length ? text[at] : '\0';
            int known = names.IndexOf(name);
            if (known >= 0)
            {
                at++;
                return meanings[known];
            }
            if (name != 'u') throw Wrong("an escape");
            int code = 0;
            for (int i = 1; i <= 4; i++)
            {
                int digit = at + i < text.Length ? "0123456789abcdef".IndexOf(char.ToLowerInvariant(text[at + i])) : -1;
                if (digit < 0) throw Wrong("four hexadecimal digits");
                code = code << 4 | digit;
            }
            at += 5;
            return (char)code;
        }

        private double Number()
        {
            int begin = at;
            if (Next('-')) at++;
            bool zero = Next('0');
            int whole = Digits();
            if (whole == 0) throw Wrong("a value");
            if (zero && whole > 1) throw new JsonException("text at " + begin + " has a number that begins with 0");
            if (Next('.'))
            {
                at++;
                if (Digits() == 0) throw Wrong("a digit");
            }
            if (Next('e') || Next('E'))
            {
                at++;
                if (Next('+') || Next('-')) at++;
                if (Digits() == 0) throw Wrong("a digit");
            }
            double number;
            bool good = double.TryParse(
                text.Substring(begin, at - begin), NumberStyles.Float, CultureInfo.InvariantCulture, out number);
            if (!good || !Wire.IsFinite(number)) throw new JsonException("text at " + begin + " has a number above any double");
            return number;
        }

        private bool Next(char character)
        {
            return at < text.Length && text[at] == character;
        }

        private int Digits()
        {
            int begin = at;
            while (at < text.Length && text[at] >= '0' && text[at] <= '9') at++;
            return at - begin;
        }
    }
}
