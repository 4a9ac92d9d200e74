// How long to wait before the next connection: longer each time, never all clients at once, and never sooner than the
// server wants.
using System;

namespace Swellcast
{
    public sealed class Backoff
    {
        /// <summary>With what chance adds, the last stays below 4 s: who was away for long is back soon.</summary>
        private static readonly int[] StepsMs = { 250, 500, 1000, 2000, 3000 };
        private readonly Random random = new Random(Guid.NewGuid().GetHashCode());
        private int attempt;

        /// <summary>It works again.</summary>
        public void Reset()
        {
            attempt = 0;
        }

        public int NextMs(int retryAfterS)
        {
            int step = StepsMs[Math.Min(attempt++, StepsMs.Length - 1)];
            var wait = (int)(step * (0.75 + 0.5 * random.NextDouble()));
            return Math.Max(wait, retryAfterS * 1000);
        }
    }
}
