// What a connection tells. Override what is needed.
using System;

namespace Swellcast
{
    /// <summary>Every member is called on the network's thread: be quick, and copy what is to be kept.</summary>
    public abstract class Listener
    {
        /// <summary>Connected, or not any more and why; it comes back by itself.</summary>
        public virtual void OnState(bool connected, string why)
        {
        }

        /// <summary>What sea this is, and what of it was asked for.</summary>
        /// <param name="same">Whether it goes on as it was: frames held of cascades that go on stay good.</param>
        public virtual void OnHello(Hello hello, Plan plan, bool same)
        {
        }

        /// <summary>
        /// A text message: `Subscribed`, `Status`, `Change`, `Quality`, `ServerError`, `PointsSubscribed`.
        /// </summary>
        public virtual void OnMessage(object message)
        {
        }

        /// <summary>A frame; it is good until this returns.</summary>
        public virtual void OnFrame(Frame frame)
        {
        }

        /// <summary>The water at the points that are followed; good until this returns.</summary>
        public virtual void OnPoints(PointsMessage points)
        {
        }

        /// <summary>A message that could not be used, and why; the connection goes on.</summary>
        public virtual void OnRefused(string why)
        {
        }

        /// <summary>A member of this listener threw; the connection goes on.</summary>
        public virtual void OnFailed(Exception error)
        {
        }
    }
}
