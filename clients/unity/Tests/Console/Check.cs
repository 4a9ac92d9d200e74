// What tests claim.
using System;

namespace Swellcast.Tests
{
    /// <summary>A test that can't be run here, and why.</summary>
    internal sealed class Skipped : Exception
    {
        public Skipped(string why) : base(why)
        {
        }
    }

    internal static class Check
    {
        public static void That(bool holds, string what)
        {
            if (!holds) throw new Exception("not so: " + what);
        }

        public static void Same<T>(T got, T must, string what)
        {
            if (!Equals(got, must)) throw new Exception(what + " is " + got + ", must be " + must);
        }

        public static void Near(double got, double must, double within, string what)
        {
            if (Math.Abs(got - must) <= within) return;
            throw new Exception(what + " is " + got + ", must be " + must + " within " + within);
        }

        public static T Throws<T>(Action action, string what) where T : Exception
        {
            try
            {
                action();
            }
            catch (T expected)
            {
                return expected;
            }
            throw new Exception(what + " was not refused");
        }
    }
}
