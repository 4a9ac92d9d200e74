// Why there is no connection, or none any more.
using System;

namespace Swellcast
{
    public sealed class StreamException : Exception
    {
        /// <summary>The server wants nobody back sooner than in so many seconds; 0 where it doesn't say.</summary>
        public readonly int RetryAfterS;

        public StreamException(string why, int retryAfterS = 0) : base(why)
        {
            RetryAfterS = retryAfterS;
        }

        /// <summary>The words of the innermost cause: those around it say only that something went wrong.</summary>
        public static StreamException Of(Exception error)
        {
            var own = error as StreamException;
            if (own != null) return own;
            while (error.InnerException != null) error = error.InnerException;
            return new StreamException(error.Message);
        }
    }
}
