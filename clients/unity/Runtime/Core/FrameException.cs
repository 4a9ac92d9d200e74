// Why a binary message must be dropped: which field, what it is, what it must be.
using System;

namespace Swellcast
{
    /// <summary>What is wrong with a binary message, by what follows from it.</summary>
    public enum Fault
    {
        /// <summary>The message is no frame: no state depends on it.</summary>
        Header,
        /// <summary>The header is right and the payload is not: later frames can't be predicted from it.</summary>
        Payload,
        /// <summary>It is predicted from a frame that is not held: its unit must begin anew.</summary>
        Missing,
    }

    /// <summary>A binary message that must be dropped as a whole.</summary>
    public sealed class FrameException : Exception
    {
        public readonly Fault Fault;
        /// <summary>The field at fault, as PROTOCOL.md names it.</summary>
        public readonly string Field;

        public FrameException(Fault fault, string field, string why) : base(field + " " + why)
        {
            Fault = fault;
            Field = field;
        }

        internal static FrameException Header(string field, string why)
        {
            return new FrameException(Fault.Header, field, why);
        }

        internal static FrameException Payload(string why)
        {
            return new FrameException(Fault.Payload, "payload", why);
        }
    }
}
