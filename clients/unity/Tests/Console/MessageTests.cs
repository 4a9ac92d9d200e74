// Text messages: the vectors of both sides, what JSON is and is not, and what a plan asks for.
using System;
using System.Collections.Generic;

namespace Swellcast.Tests
{
    internal static class MessageTests
    {
        public static void Add(Tests tests)
        {
            tests.Add("vectors: messages", Messages);
            tests.Add("vectors: invalid messages", InvalidMessages);
            tests.Add("messages: values of hello", HelloValues);
            tests.Add("messages: refused ones of a server", Refused);
            tests.Add("messages: what is sent is what a server takes", Sent);
            tests.Add("messages: a plan keeps within what is offered", Plans);
            tests.Add("address: what people type", Addresses);
        }

        private static void Messages()
        {
            foreach (JsonValue vector in Vectors.Json("messages.json").Items)
            {
                string about = vector["about"].Text, text = vector["text"].Text;
                if (vector["from"].Text == "client")
                {
                    ClientMessages.Check(text, 131072);
                    continue;
                }
                bool ignore = vector["ignore"] != null && vector["ignore"].Boolean;
                Check.Same(ServerMessages.Read(text) == null, ignore, about + " is ignored");
            }
        }

        private static void InvalidMessages()
        {
            foreach (JsonValue vector in Vectors.Json("invalid/messages.json").Items)
            {
                string why = vector["why"].Text, text = vector["text"].Text;
                var error = Check.Throws<MessageException>(() => ClientMessages.Check(text, 131072), why);
                Check.Same(error.Code, vector["code"].Text, why + ", refused as \"" + error.Message + "\"");
                Check.Same(error.Field, vector["field"].Text, why + ", refused as \"" + error.Message + "\"");
            }
        }

        private static Hello FirstHello(string about)
        {
            foreach (JsonValue vector in Vectors.Json("messages.json").Items)
            {
                if (vector["about"].Text == about) return (Hello)ServerMessages.Read(vector["text"].Text);
            }
            throw new Exception("no vector about " + about);
        }

        private static void HelloValues()
        {
            Hello hello = FirstHello("hello");
            Check.Same(hello.Epoch, 0x0123456789abcdefUL, "epoch");
            Check.Same(hello.Seed, "18446744073709551615", "seed");
            Check.Same(hello.Cascades[1].PatchM, 19.5, "patch_m");
            Check.Same(hello.Cascades[1].UntilTick, null, "until_tick");
            Check.Same(hello.Classes[3].DisplacementM, 0.02, "class 20mm");
            Check.Same(string.Join(" ", hello.Groups), string.Join(" ", Names.Groups), "groups");
            Check.Same(hello.MostPoints, 2000, "points");
            Hello further = FirstHello("a further hello, while the layout changes");
            Check.Same(further.Cascades[0].UntilTick, 622160640, "until_tick");
            Check.Same(further.Find(8).Details[0].RateHz, 15, "rate of displacement");
            Check.Same(further.Find(8).Details[1].RateHz, null, "any rate of slopes");
        }

        private static void Refused()
        {
            string good = Samples.Hello();
            ServerMessages.Read(good);
            string[,] bad =
            {
                { "\"protocol\":1", "\"protocol\":2" }, { "\"ticks_per_second\":7200", "\"ticks_per_second\":1000" },
                { "\"epoch\":\"ab54a98ceb1f0ad2\"", "\"epoch\":\"xyz\"" }, { "\"rates_hz\":[15,30]", "\"rates_hz\":[]" },
                { "\"rates_hz\":[15,30]", "\"rates_hz\":[7]" }, { "\"patch_m\":64", "\"patch_m\":0" },
                { "\"n\":8", "\"n\":1e9" }, { "\"lead_ticks\":1680", "\"lead_ticks\":1e15" },
                { "\"until_tick\":null", "\"until_tick\":-1" }, { "\"limits\":{", "\"limits\":[{" },
            };
            for (int i = 0; i < bad.GetLength(0); i++)
            {
                string text = good.Replace(bad[i, 0], bad[i, 1]);
                Check.That(text != good, bad[i, 1] + " is in the message");
                Check.Throws<MessageException>(() => ServerMessages.Read(text), bad[i, 1]);
            }
            foreach (string text in new[] { "", "[]", "{", "{\"type\":1}", "{\"type\":\"time\",\"t0\":1}" })
            {
                Check.Throws<MessageException>(() => ServerMessages.Read(text), text);
            }
            string far = "{\"type\":\"novelty\",\"a\":\"" + new string('x', ServerMessages.MostLength) + "\"}";
            Check.Throws<MessageException>(() => ServerMessages.Read(far), "a text that is too long");
            Check.Same(ServerMessages.Read("{\"type\":\"novelty\",\"a\":[1,2.5e-3,\"\\ud83c\\udf0a\"]}"), null, "novelty");
        }

        private static void Sent()
        {
            var units = new[] { new UnitName { Class = "1mm", Group = "foam", Codec = "rans", RateHz = 15 } };
            foreach (string text in new[]
            {
                ClientMessages.Subscribe(Wire.MaxTick, 15, units, true), ClientMessages.Time(-1234567890123),
                ClientMessages.Report(7200, 0.1, -1e-7, true), ClientMessages.Points(3, 30, new[] { 0.1, -1e9 }),
            })
            {
                ClientMessages.Check(text, 4096);
            }
            Check.Same(ClientMessages.Time(7), "{\"type\":\"time\",\"t0\":7}", "time");
            Check.Throws<ArgumentException>(() => ClientMessages.Report(0, double.NaN, 0, false), "NaN");
            string beyond = ClientMessages.Points(3, 30, new[] { 0, 1.1e9 });
            Check.Same(Check.Throws<MessageException>(() => ClientMessages.Check(beyond, 4096), beyond).Field, "points[0][1]", "field");
            Check.Same(new JsonWriter().Value("\"\\\n\u0001ä").ToString(), "\"\\\"\\\\\\u000a\\u0001ä\"", "escapes");
        }

        private static void Plans()
        {
            Hello hello = FirstHello("a further hello, while the layout changes");
            var wish = new Wish { Groups = new[] { "displacement", "none", "slopes" }, RateHz = 28, Class = "no such" };
            Plan plan = Plan.Of(hello, wish);
            Check.Same(plan.RateHz, 30, "rate");
            Check.Same(plan.Units.Count, 4, "units");
            Check.Same(plan.Units[0].Class, "0.5mm", "the first class");
            Check.Same(plan.Units[1].Level, 1, "no finer than there is");
            Check.Same(plan.Units[1].RateHz, 15, "no more often than there is");
            Check.Same(plan.Units[3].Level, 2, "slopes");
            Check.Same(plan.IntervalOf(plan.Units[1]), 480, "ticks");
            hello.MostUnits = 3;
            Check.Same(Plan.Of(hello, wish).Units.Count, 3, "most units");
            hello.MessageBytes = 180;
            Check.Same(Plan.Of(hello, wish).Units.Count, 1, "units in a short message");
            wish.Level = 9;
            wish.Cascades = new[] { 0 };
            Check.Same(Plan.Of(hello, wish).Units[0].Level, 3, "the coarsest");
        }

        private static void Addresses()
        {
            string[,] good =
            {
                { "http://127.0.0.1:8080", "ws://127.0.0.1:8080/v1/stream" },
                { "http://127.0.0.1:8080/", "ws://127.0.0.1:8080/v1/stream" },
                { "ws://sea.example/v1/stream", "ws://sea.example/v1/stream" },
                { "localhost:9000", "ws://localhost:9000/v1/stream" },
                { "https://sea.example", "wss://sea.example/v1/stream" },
                { "http://[::1]:8080", "ws://[::1]:8080/v1/stream" },
            };
            for (int i = 0; i < good.GetLength(0); i++) Check.Same(Address.Of(good[i, 0]).AbsoluteUri, good[i, 1], good[i, 0]);
            foreach (string url in new[] { "", null, "ftp://sea.example", "http://", "http:// ", "http://a:b:c" })
            {
                Check.Throws<ArgumentException>(() => Address.Of(url), "\"" + url + "\"");
            }
        }
    }
}
