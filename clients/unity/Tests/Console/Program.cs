// Runs the tests of the core on plain Mono or .NET: every vector of proto/vectors, laws of each part, and a live server.
using System;
using System.Collections.Generic;

namespace Swellcast.Tests
{
    /// <summary>Tests by name, in the order in which they are run.</summary>
    internal sealed class Tests
    {
        public readonly List<KeyValuePair<string, Action>> All = new List<KeyValuePair<string, Action>>();

        public void Add(string name, Action test)
        {
            All.Add(new KeyValuePair<string, Action>(name, test));
        }
    }

    internal static class Program
    {
        /// <summary>
        /// Arguments: the folder of vectors, and perhaps part of the names of tests to run; or `bench`.
        /// </summary>
        private static int Main(string[] args)
        {
            if (args.Length == 0)
            {
                Console.Error.WriteLine("usage: Tests.exe VECTORS [NAME]\n       Tests.exe bench [SECONDS]");
                return 2;
            }
            if (args[0] == "bench") return DecodeBench.Run(args.Length > 1 ? int.Parse(args[1]) : 4);
            Vectors.Folder = args[0];
            var tests = new Tests();
            VectorTests.Add(tests);
            MessageTests.Add(tests);
            ClockTests.Add(tests);
            DecoderTests.Add(tests);
            RingTests.Add(tests);
            SeaTests.Add(tests);
            SessionTests.Add(tests);
            SocketTests.Add(tests);
            LiveTests.Add(tests);
            int failed = 0, run = 0;
            foreach (KeyValuePair<string, Action> test in tests.All)
            {
                if (args.Length > 1 && !test.Key.Contains(args[1])) continue;
                run++;
                try
                {
                    test.Value();
                    Console.WriteLine("ok      " + test.Key);
                }
                catch (Skipped skipped)
                {
                    Console.WriteLine("SKIPPED " + test.Key + ": " + skipped.Message);
                }
                catch (Exception error)
                {
                    failed++;
                    Console.WriteLine("FAILED  " + test.Key + "\n" + error);
                }
            }
            Console.WriteLine(run + " tests, " + failed + " failed");
            return failed > 0 || run == 0 ? 1 : 0;
        }
    }
}
