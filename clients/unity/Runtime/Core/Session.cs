// What is said in one connection after another (PROTOCOL.md sections 2 to 6): subscribes, exchanges time, decodes,
// reports. Knows neither sockets nor threads: messages and time are arguments, and what is to be sent goes to a sender.
using System;
using System.Collections.Generic;

namespace Swellcast
{
    public interface ISender
    {
        void Send(string text);
    }

    public sealed class Session
    {
        private const long FastUs = 100000, SlowUs = 1000000, ReportUs = 1000000;
        private const int FastExchanges = 20;
        /// <summary>`status` comes once a second: longer silence is a dead connection.</summary>
        private const long SilenceUs = 8000000;
        /// <summary>Exchanges whose answers are still awaited.</summary>
        private const int MostAsked = 16;
        /// <summary>Most samples of one moment that are kept for predictions.</summary>
        private const long MostSamples = 1 << 25;

        private readonly Listener listener;
        private readonly Func<long> now;
        private readonly Decoder decoder = new Decoder(0);
        private readonly PointsMessage water = new PointsMessage();
        private readonly Fares fares = new Fares();
        private readonly List<long> asked = new List<long>();
        private readonly Clock clock = new Clock();
        private ISender sender;
        private Hello hello;
        private Plan plan;
        private Wish wish;
        private double[] points = new double[0];
        private int pointsRate;
        private bool followed; // points were asked for in this connection
        private long nextId, pointsId = -1, heard, nextExchange, nextReport, anew = long.MinValue;
        private int exchanges;
        private ulong? epoch; // of the newest hello, through reconnections

        /// <param name="now">Own time in microseconds, of a clock that only goes forward.</param>
        public Session(Wish wish, Listener listener, Func<long> now)
        {
            this.wish = wish;
            this.listener = listener;
            this.now = now;
        }

        /// <summary>Whether a frame was decoded in this connection.</summary>
        public bool Works { get; private set; }

        /// <summary>Server time now, in ticks with a fraction; NaN before the first exchange. For any thread.</summary>
        public double Ticks()
        {
            lock (clock) return clock.Ticks(now());
        }

        /// <summary>How far that can be off, in microseconds. For any thread.</summary>
        public double ErrorBoundUs()
        {
            lock (clock) return clock.ErrorBoundUs(now());
        }

        /// <summary>A connection is open.</summary>
        public void Begin(ISender sender)
        {
            this.sender = sender;
            hello = null;
            plan = null;
            decoder.Clear();
            decoder.MostSamples = 0;
            fares.Reset();
            asked.Clear();
            exchanges = 0;
            followed = false;
            pointsId = -1;
            anew = long.MinValue;
            Works = false;
            heard = now();
            nextReport = heard + ReportUs;
        }

        /// <summary>Asks for something else.</summary>
        public void Ask(Wish wanted)
        {
            wish = wanted;
            if (hello == null) return;
            plan = Plan.Of(hello, wish);
            listener.OnHello(hello, plan, true);
            Send(plan.Message(++nextId));
        }

        /// <summary>Follows other points: x and z of each in turn, metres.</summary>
        public void Follow(double[] xz, int rateHz)
        {
            points = xz;
            pointsRate = rateHz;
            if (hello != null) SendPoints();
        }

        /// <summary>Why the connection is to be given up: nothing was heard for long; else null.</summary>
        public string Ailment()
        {
            return now() - heard > SilenceUs ? "the server is silent" : null;
        }

        /// <summary>To be called every 100 ms or so.</summary>
        public void Beat()
        {
            if (hello == null) return;
            long at = now();
            if (at >= nextExchange)
            {
                nextExchange = at + (exchanges++ < FastExchanges ? FastUs : SlowUs);
                if (asked.Count == MostAsked) asked.RemoveAt(0);
                asked.Add(at);
                Send(ClientMessages.Time(at));
            }
            if (at >= nextReport)
            {
                nextReport = at + ReportUs;
                if (wish.Reports && fares.Newest > 0 && clock.Synced) Report(false);
            }
        }

        /// <summary>A text message came, at own time `at`.</summary>
        public void Text(string text, long at)
        {
            heard = at;
            object message;
            try
            {
                message = ServerMessages.Read(text);
            }
            catch (MessageException error)
            {
                listener.OnRefused(error.Message);
                return;
            }
            if (message == null) return;
            var answer = message as TimeAnswer;
            var greeting = message as Hello;
            if (answer != null)
            {
                Answered(answer, at);
            }
            else if (greeting != null)
            {
                Greeted(greeting);
            }
            else
            {
                var granted = message as Subscribed;
                if (granted != null) Granted(granted);
                listener.OnMessage(message);
            }
        }

        private void Answered(TimeAnswer answer, long at)
        {
            for (int i = 0; i < asked.Count; i++)
            {
                if (asked[i] != answer.T0) continue;
                long t0 = asked[i];
                asked.RemoveAt(i);
                lock (clock) clock.Observe(t0, answer.T1Us, answer.T2Us, at);
                return;
            }
        }

        private void Greeted(Hello greeting)
        {
            bool same = epoch == greeting.Epoch, further = hello != null && same; // the layout changes: all else goes on
            if (!same)
            {
                lock (clock) clock.Reset();
                decoder.Clear();
            }
            epoch = greeting.Epoch;
            decoder.Epoch = epoch;
            hello = greeting;
            plan = Plan.Of(hello, wish);
            listener.OnHello(hello, plan, same);
            if (!further)
            {
                listener.OnState(true, "");
                nextExchange = long.MinValue;
            }
            Send(plan.Message(++nextId));
            if (!followed && points.Length > 0) SendPoints();
            Beat();
        }

        /// <summary>What was granted is all that goes on, and all of it at full quality.</summary>
        private void Granted(Subscribed granted)
        {
            long samples = 0;
            foreach (UnitName unit in granted.Units)
            {
                Cascade cascade = hello == null ? null : hello.Find(unit.Cascade);
                int group = Names.IndexOf(Names.Groups, unit.Group);
                if (cascade == null || group < 0 || unit.Level > 16) continue;
                long side = cascade.N >> unit.Level;
                samples += side * side * Names.GroupChannels[group];
            }
            // A level and coarser ones, while the server goes from one to the other.
            decoder.MostSamples = Math.Min(MostSamples, samples + samples / 2);
            decoder.Retain((cascade, level, kind, group, codec) =>
            {
                foreach (UnitName unit in granted.Units)
                {
                    bool same = unit.Cascade == cascade && unit.Level == level && unit.Class == Names.Classes[kind]
                        && unit.Group == Names.Groups[group] && unit.Codec == Names.Codecs[codec];
                    if (same) return true;
                }
                return false;
            });
            fares.Reset();
        }

        /// <summary>A binary message came, at own time `at`.</summary>
        public void Binary(byte[] bytes, int offset, int length, long at)
        {
            heard = at;
            if (hello == null) return;
            try
            {
                if (PointsMessage.Is(bytes, offset, length)) Points(bytes, offset, length);
                else Decode(bytes, offset, length);
            }
            catch (FrameException error)
            {
                Refused(error);
            }
        }

        private void Points(byte[] bytes, int offset, int length)
        {
            water.Read(bytes, offset, length, points.Length / 2);
            if (water.Epoch == hello.Epoch && water.Id == (ulong)pointsId) listener.OnPoints(water);
        }

        private void Decode(byte[] bytes, int offset, int length)
        {
            long began = now();
            Frame frame = decoder.Decode(bytes, offset, length);
            if (frame == null) return; // of another sea
            fares.Decoded(frame.Header.Tick, now() - began);
            Works = true;
            Cascade cascade = hello.Find(frame.Header.Cascade);
            if (cascade != null && cascade.IsThere(frame.Header.Tick)) listener.OnFrame(frame);
        }

        /// <summary>
        /// A frame that can't be read may leave others unread: all begins anew, unless that was asked for just now.
        /// </summary>
        private void Refused(FrameException error)
        {
            long at = now();
            bool waits = anew != long.MinValue && at - anew < ReportUs;
            if (error.Fault != Fault.Header && !waits)
            {
                anew = at;
                Report(true);
            }
            // What was under way when a new beginning was asked for is no fault.
            if (!(error.Fault == Fault.Missing && waits)) listener.OnRefused(error.Message);
        }

        private void Report(bool lost)
        {
            Send(fares.Report(Ticks(), lost));
        }

        private void SendPoints()
        {
            followed = true;
            pointsId = ++nextId;
            int most = hello.MostPoints, count = points.Length / 2;
            if (count > most)
            {
                listener.OnRefused("points has " + count + " elements, must have at most " + most);
                return;
            }
            Send(ClientMessages.Points(pointsId, Plan.NearestRate(hello, pointsRate), points));
        }

        /// <summary>Sends what a server would take; what it would not, a wish of somebody, is refused here.</summary>
        private void Send(string text)
        {
            try
            {
                ClientMessages.Check(text, hello.MessageBytes);
            }
            catch (MessageException error)
            {
                listener.OnRefused(error.Message);
                return;
            }
            sender.Send(text);
        }
    }
}
