// Stays connected to a server: a thread that opens a socket, lets the session speak through it, and when that is over
// waits and opens another.
using System;
using System.Diagnostics;
using System.Threading;

namespace Swellcast
{
    public sealed class Connection : IDisposable
    {
        private const int BeatMs = 50;
        /// <summary>A server takes four subscriptions a second for long.</summary>
        private const long BetweenAsksUs = 300000;
        private static readonly Stopwatch Watch = Stopwatch.StartNew();

        private readonly Uri uri;
        private readonly Listener listener;
        private readonly Session session;
        private readonly Backoff backoff = new Backoff();
        private readonly ManualResetEvent stop = new ManualResetEvent(false);
        private readonly Thread thread;
        private readonly object gate = new object();
        private volatile bool open;
        private Wish wish; // asked for and not yet said; under the gate
        private double[] points;
        private int pointsRate;
        private long asked = -BetweenAsksUs;

        /// <summary>Connects, and stays connected until it is disposed of.</summary>
        /// <exception cref="ArgumentException">The URL can't be used.</exception>
        public Connection(string url, Wish wish, Listener listener)
        {
            uri = Address.Of(url);
            this.listener = listener;
            session = new Session(wish, listener, NowUs);
            thread = new Thread(Run) { IsBackground = true, Name = "Swellcast" };
            thread.Start();
        }

        /// <summary>Own time in microseconds.</summary>
        public static long NowUs()
        {
            return (long)(Watch.ElapsedTicks * (1e6 / Stopwatch.Frequency));
        }

        /// <summary>Server time now, in ticks with a fraction; NaN while it is not known.</summary>
        public double Ticks { get { return session.Ticks(); } }

        /// <summary>How far that can be off, in microseconds.</summary>
        public double ErrorBoundUs { get { return session.ErrorBoundUs(); } }

        /// <summary>Asks for something else; `OnHello` tells the new plan.</summary>
        public void Ask(Wish wanted)
        {
            lock (gate) wish = wanted;
        }

        /// <summary>Follows these points: x and z of each in turn, metres. An empty array ends it.</summary>
        public void Follow(double[] xz, int rateHz)
        {
            lock (gate)
            {
                points = (double[])xz.Clone();
                pointsRate = rateHz;
            }
        }

        /// <summary>Ends it. Who waits for a server that is not there is not waited for.</summary>
        public void Dispose()
        {
            stop.Set();
            if (open && Thread.CurrentThread != thread) thread.Join(1000);
        }

        private void Run()
        {
            int waitMs;
            do
            {
                try
                {
                    using (StreamSocket socket = StreamSocket.Open(uri)) Stay(socket);
                    return;
                }
                catch (Exception error)
                {
                    open = false;
                    StreamException why = StreamException.Of(error);
                    waitMs = backoff.NextMs(why.RetryAfterS);
                    Lost(why.Message);
                }
            }
            while (!stop.WaitOne(waitMs));
        }

        /// <summary>Until this is disposed of, or the connection is over, by an exception.</summary>
        private void Stay(StreamSocket socket)
        {
            open = true;
            session.Begin(socket);
            while (!stop.WaitOne(0))
            {
                bool received = socket.Receive(BeatMs);
                try
                {
                    if (received) Take(socket);
                    Beat();
                }
                catch (StreamException)
                {
                    throw; // sending failed
                }
                catch (Exception error)
                {
                    Failed(error); // the listener's: what was received was taken in before it was told
                }
                string ailment = session.Ailment();
                if (ailment != null) throw new StreamException(ailment);
            }
            socket.Close();
        }

        private void Take(StreamSocket socket)
        {
            long at = NowUs();
            if (!socket.IsText)
            {
                session.Binary(socket.Bytes, 0, socket.Length, at);
                if (session.Works) backoff.Reset();
                return;
            }
            string text = socket.Text();
            if (text == null) throw new StreamException("text is not UTF-8");
            session.Text(text, at);
        }

        private void Beat()
        {
            session.Beat();
            Wish wanted = null;
            double[] followed = null;
            int followedRate = 0;
            lock (gate)
            {
                long at = NowUs();
                if (wish != null && at - asked >= BetweenAsksUs)
                {
                    wanted = wish;
                    wish = null;
                }
                else if (points != null && at - asked >= BetweenAsksUs)
                {
                    followed = points;
                    followedRate = pointsRate;
                    points = null;
                }
                if (wanted != null || followed != null) asked = at;
            }
            if (wanted != null) session.Ask(wanted);
            if (followed != null) session.Follow(followed, followedRate);
        }

        private void Lost(string why)
        {
            try
            {
                listener.OnState(false, why);
            }
            catch (Exception error)
            {
                Failed(error);
            }
        }

        private void Failed(Exception error)
        {
            try
            {
                listener.OnFailed(error);
            }
            catch (Exception)
            {
                // Who fails at hearing of a failure can't be told.
            }
        }
    }
}
