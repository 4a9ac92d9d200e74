// A session without sockets: order of messages, refusals, what is reported, what is followed.
using System;
using System.Collections.Generic;

namespace Swellcast.Tests
{
    internal static class SessionTests
    {
        public static void Add(Tests tests)
        {
            tests.Add("session: after hello it subscribes and exchanges time", Order);
            tests.Add("session: broken frames and texts are refused, and it goes on", Broken);
            tests.Add("session: a further hello, and another sea", Hellos);
            tests.Add("session: once a second it reports how it fares", Reports);
            tests.Add("session: what can't be read is said, once a second at most", Lost);
            tests.Add("session: points", Points);
            tests.Add("session: silence is an ailment", Silence);
        }

        /// <summary>A session, its time, what it says and what it tells.</summary>
        private sealed class Stage : Listener, ISender
        {
            public readonly List<string> Sent = new List<string>(), Heard = new List<string>();
            public readonly Session Session;
            public long Now = 1000000;

            public Stage(params string[] groups)
            {
                Session = new Session(new Wish { Groups = groups }, this, () => Now);
                Session.Begin(this);
            }

            public void Send(string text)
            {
                ClientMessages.Check(text, 4096);
                Sent.Add(text);
            }

            public void Say(string text)
            {
                Session.Text(text, Now);
            }

            public void Say(byte[] frame)
            {
                Session.Binary(frame, 0, frame.Length, Now);
            }

            public void Pass(int ms)
            {
                for (int i = 0; i < ms; i += 50)
                {
                    Now += 50000;
                    Session.Beat();
                }
            }

            public List<string> Of(string type)
            {
                return Sent.FindAll(text => text.Contains("\"type\":\"" + type + "\""));
            }

            public override void OnState(bool connected, string why)
            {
                Heard.Add("state");
            }

            public override void OnHello(Hello hello, Plan plan, bool same)
            {
                Heard.Add(same ? "same" : "hello");
            }

            public override void OnMessage(object message)
            {
                Heard.Add(message.GetType().Name);
            }

            public override void OnFrame(Frame frame)
            {
                Heard.Add("frame " + frame.Header.Cascade);
            }

            public override void OnPoints(PointsMessage points)
            {
                Heard.Add("points " + points.Count);
            }

            public override void OnRefused(string why)
            {
                Heard.Add("refused");
            }

            public void Expect(params string[] heard)
            {
                Check.Same(string.Join(", ", Heard), string.Join(", ", heard), "what was told");
                Heard.Clear();
            }
        }

        private const string Unit = "{\"cascade\":1,\"level\":0,\"class\":\"1mm\",\"group\":\"foam\",\"codec\":\"rans\"}";

        private static string Subscribed(string units)
        {
            return "{\"type\":\"subscribed\",\"id\":1,\"rate_hz\":15,\"units\":[" + units + "],\"from_tick\":0}";
        }

        private static byte[] Still(long tick, int depth)
        {
            return Samples.Frame(Group.Foam, tick, codec: Codec.Rans, depth: depth, payload: Samples.StillFoam());
        }

        private static void Order()
        {
            var stage = new Stage("displacement", "foam");
            stage.Pass(1000);
            Check.Same(stage.Sent.Count, 0, "nothing before hello");
            stage.Say(Samples.Hello());
            stage.Expect("hello", "state");
            Check.Same(stage.Of("subscribe").Count, 1, "subscriptions");
            Check.Same(JsonReader.Read(stage.Sent[0], 9999)["units"].Items.Count, 2, "units");
            Check.Same(stage.Of("time").Count, 1, "exchanges");
            stage.Pass(1000);
            Check.Near(stage.Of("time").Count, 11, 1, "exchanges at first");
            stage.Pass(9000);
            Check.Near(stage.Of("time").Count, 28, 2, "exchanges later");
            Check.That(double.IsNaN(stage.Session.Ticks()), "no time yet");
            double t0 = JsonReader.Read(stage.Of("time")[27], 999)["t0"].Number;
            string answer = "{\"type\":\"time\",\"t0\":" + t0 + ",\"t1_us\":5000000,\"t2_us\":5000000}";
            stage.Now = (long)t0;
            stage.Say(answer.Replace("\"t0\":", "\"t0\":3"));
            Check.That(double.IsNaN(stage.Session.Ticks()), "an answer that was not asked for");
            stage.Say(answer);
            Check.Near(stage.Session.Ticks(), 36000, 0.01, "ticks");
        }

        private static void Broken()
        {
            var stage = new Stage("displacement");
            stage.Say(Samples.Frame()); // before hello it is not known what it is
            stage.Say(Samples.Hello());
            stage.Say(Samples.Frame());
            byte[] wrong = Samples.Frame();
            wrong[10] = 9;
            stage.Say(wrong);
            stage.Say(new byte[0]);
            stage.Say("{");
            stage.Say("{\"type\":\"novelty\"}");
            stage.Say(Samples.Frame(epoch: 7));
            stage.Say("{\"type\":\"status\",\"tick\":1,\"sequence\":1,\"hs_m\":1,\"wind\":null}");
            stage.Expect("hello", "state", "frame 1", "refused", "refused", "refused", "Status");
            Check.Same(stage.Of("report").Count, 0, "a frame of another protocol: a new beginning would change nothing");
        }

        private static void Hellos()
        {
            var stage = new Stage("displacement");
            stage.Say(Samples.Hello());
            string both = Samples.CascadeOf(1, 8, 0, 72000) + "," + Samples.CascadeOf(8, 8, 36000, null);
            int before = stage.Sent.Count;
            stage.Say(Samples.Hello(cascades: both));
            Check.Same(stage.Sent.Count, before + 1, "it subscribes once more, and time goes on as it did");
            stage.Expect("hello", "state", "same");
            foreach (int tick in new[] { 71520, 72000 }) stage.Say(Samples.Frame(tick: tick));
            foreach (int tick in new[] { 35520, 36000, 144000 }) stage.Say(Samples.Frame(tick: tick, cascade: 8));
            stage.Say(Samples.Frame(tick: 36000, cascade: 3));
            stage.Expect("frame 1", "frame 8", "frame 8");
            stage.Session.Begin(stage);
            stage.Say(Samples.Hello());
            stage.Expect("same", "state");
            stage.Session.Begin(stage);
            stage.Say(Samples.Hello(7));
            stage.Say(Samples.Frame());
            stage.Say(Samples.Frame(epoch: 7));
            stage.Expect("hello", "state", "frame 1");
        }

        private static void Reports()
        {
            var stage = new Stage("foam");
            stage.Say(Samples.Hello());
            double t0 = JsonReader.Read(stage.Of("time")[0], 999)["t0"].Number;
            stage.Say("{\"type\":\"time\",\"t0\":" + t0 + ",\"t1_us\":1000000,\"t2_us\":1000000}");
            stage.Pass(1500);
            Check.Same(stage.Of("report").Count, 0, "nothing to tell");
            stage.Say(Subscribed(Unit));
            stage.Say(Still(14400, 0));
            stage.Say(Still(14880, 1));
            stage.Pass(1000);
            Check.Same(stage.Of("report").Count, 1, "reports");
            JsonValue report = JsonReader.Read(stage.Of("report")[0], 999);
            Check.Same(report["tick"].Number, 14880d, "tick");
            Check.Near(report["buffer_ms"].Number, 14880 / 7.2 - 3000, 60, "buffer");
            stage.Say(Subscribed(""));
            stage.Pass(1000);
            Check.Same(stage.Of("report").Count, 1, "another subscription: nothing to tell yet");
        }

        private static void Lost()
        {
            var stage = new Stage("foam");
            stage.Say(Samples.Hello());
            stage.Say(Subscribed(Unit));
            stage.Heard.Clear();
            stage.Say(Still(960, 2));
            Check.Same(stage.Of("report").Count, 1, "said at once");
            Check.That(stage.Of("report")[0].Contains("\"lost\":true"), "lost");
            stage.Say(Still(1440, 3));
            stage.Say(Still(1920, 0));
            stage.Say(Still(2400, 1));
            Check.Same(stage.Of("report").Count, 1, "once");
            stage.Expect("refused", "frame 1", "frame 1");
            stage.Now += 1000000;
            stage.Say(Still(4800, 2));
            Check.Same(stage.Of("report").Count, 2, "again");
            // Units that were not granted again are forgotten.
            stage.Say(Still(5280, 0));
            stage.Say(Subscribed(Unit));
            stage.Say(Still(5760, 1));
            stage.Say(Subscribed(Unit.Replace("1mm", "5mm")));
            stage.Heard.Clear();
            stage.Now += 1000000;
            stage.Say(Still(6240, 2));
            stage.Expect("refused");
        }

        private static void Points()
        {
            var stage = new Stage("foam");
            stage.Session.Follow(new[] { 1.5, -2 }, 15);
            stage.Say(Samples.Hello());
            Check.Same(stage.Of("points").Count, 1, "asked for");
            double id = JsonReader.Read(stage.Of("points")[0], 999)["id"].Number;
            byte[] message = Vectors.Bytes("points/largest.bin"); // one point
            Samples.Put(message, 24, unchecked((long)Samples.Epoch), 8);
            foreach (int of in new[] { (int)id, (int)id + 1 })
            {
                Samples.Put(message, 40, of, 8);
                Samples.Put(message, 48, Crc32.Of(Crc32.Of(0, message, 0, 48), message, 56, message.Length - 56), 4);
                stage.Say(message);
            }
            stage.Expect("hello", "state", "points 1");
            stage.Session.Follow(new double[6], 15);
            stage.Session.Follow(new[] { 0, 2e9 }, 15);
            stage.Expect("refused", "refused");
            Check.Same(stage.Of("points").Count, 1, "what would be refused is not sent");
            stage.Session.Begin(stage);
            stage.Session.Follow(new[] { 3.0, 4 }, 15);
            stage.Say(Samples.Hello());
            Check.Same(stage.Of("points").Count, 2, "asked for anew");
        }

        private static void Silence()
        {
            var stage = new Stage("foam");
            stage.Say(Samples.Hello());
            stage.Pass(7900);
            Check.Same(stage.Session.Ailment(), null, "ailment");
            stage.Pass(200);
            Check.That(stage.Session.Ailment() != null, "ailment");
        }
    }
}
