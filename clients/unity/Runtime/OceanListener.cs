// What the network's thread leaves for Unity's: the sea, and what there is to say about the connection.
using System;

namespace Swellcast
{
    internal sealed class OceanListener : Listener
    {
        private readonly object gate = new object();
        private Sea sea;
        private bool connected;
        private string news; // not yet said
        private Exception failure;

        /// <summary>The sea; null before the first hello, another one whenever the layout changes.</summary>
        public Sea Sea
        {
            get { lock (gate) return sea; }
        }

        public bool Connected
        {
            get { lock (gate) return connected; }
        }

        /// <summary>What there is to say since the last time: null for nothing.</summary>
        public string TakeNews()
        {
            lock (gate)
            {
                string taken = news;
                news = null;
                return taken;
            }
        }

        /// <summary>An error of this package, to be logged: null for none.</summary>
        public Exception TakeFailure()
        {
            lock (gate)
            {
                Exception taken = failure;
                failure = null;
                return taken;
            }
        }

        public override void OnHello(Hello hello, Plan plan, bool same)
        {
            // Frames of cascades that go on are taken over, so that the picture doesn't stop.
            var next = new Sea(hello, plan, same ? Sea : null);
            lock (gate) sea = next;
            if (plan.Units.Count == 0) Say("the server has nothing of what was asked for");
            if (next.LeftOut > 0) Say(next.LeftOut + " units are too large to be held; ask for a coarser level");
        }

        public override void OnState(bool connected, string why)
        {
            lock (gate) this.connected = connected;
            Say(connected ? "connected" : "not connected: " + why);
        }

        public override void OnMessage(object message)
        {
            var error = message as ServerError;
            if (error != null) Say("the server refused " + error);
        }

        public override void OnFrame(Frame frame)
        {
            Sea.Accept(frame);
        }

        public override void OnRefused(string why)
        {
            Say("dropped: " + why);
        }

        public override void OnFailed(Exception error)
        {
            lock (gate) failure = error;
        }

        private void Say(string what)
        {
            lock (gate) news = what;
        }
    }
}
