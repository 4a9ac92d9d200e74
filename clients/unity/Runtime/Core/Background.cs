// Work on another thread, one piece at a time: who starts it looks in again later, and never waits.
using System;
using System.Threading;

namespace Swellcast
{
    public sealed class Background
    {
        private readonly WaitCallback run;
        private Action work;
        private Exception error;
        private volatile bool busy;

        public Background()
        {
            run = Run;
        }

        /// <summary>Whether nothing is under way: what was started is done, and its results may be looked at.</summary>
        public bool Idle { get { return !busy; } }

        /// <summary>Starts a piece of work; only when idle.</summary>
        public void Start(Action work)
        {
            this.work = work;
            busy = true;
            ThreadPool.QueueUserWorkItem(run);
        }

        /// <summary>What the work that is done threw; null for nothing.</summary>
        public Exception TakeError()
        {
            Exception taken = error;
            error = null;
            return taken;
        }

        private void Run(object state)
        {
            try
            {
                work();
            }
            catch (Exception thrown)
            {
                error = thrown;
            }
            busy = false;
        }
    }
}
