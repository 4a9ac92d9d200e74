// A server of our own, named by SWELLCAST_BIN, at a free port of this machine; stopped with the test.
using System;
using System.Diagnostics;
using System.IO;
using System.Text.RegularExpressions;
using System.Threading;

namespace Swellcast.Tests
{
    internal sealed class LocalServer : IDisposable
    {
        private readonly Process process;
        private readonly ManualResetEvent ready = new ManualResetEvent(false);
        private string said = "";

        public string Url { get; private set; }
        public int Port { get; private set; }

        /// <param name="data">Folder that keeps its log, so that it is the same sea after a restart.</param>
        /// <param name="port">0: any that is free.</param>
        public LocalServer(string data, int port = 0)
        {
            string binary = Environment.GetEnvironmentVariable("SWELLCAST_BIN");
            if (string.IsNullOrEmpty(binary)) throw new Skipped("SWELLCAST_BIN names no server");
            var start = new ProcessStartInfo(binary, "serve --listen 127.0.0.1:" + port + " --data \"" + data + "\"")
            {
                UseShellExecute = false,
                RedirectStandardOutput = true,
                RedirectStandardError = true,
            };
            process = new Process { StartInfo = start };
            process.OutputDataReceived += (sender, line) => Heard(line.Data);
            process.ErrorDataReceived += (sender, line) => Heard(line.Data);
            process.Start();
            process.BeginOutputReadLine();
            process.BeginErrorReadLine();
            if (ready.WaitOne(60000)) return;
            Kill();
            throw new Exception("the server did not say its address within 60 s; it said:\n" + said);
        }

        private void Heard(string line)
        {
            if (line == null) return;
            if (said.Length < 4000) said += line + "\n";
            Match match = Regex.Match(line, "http://127\\.0\\.0\\.1:([0-9]+)");
            if (!match.Success || Url != null) return;
            Port = int.Parse(match.Groups[1].Value);
            Url = match.Value;
            ready.Set();
        }

        public void Kill()
        {
            try
            {
                process.Kill();
                process.WaitForExit(5000);
            }
            catch (InvalidOperationException)
            {
                // It has ended already.
            }
        }

        public void Dispose()
        {
            Kill();
            process.Dispose();
        }

        /// <summary>A new folder below the system's own for such.</summary>
        public static string NewFolder()
        {
            string folder = Path.Combine(Path.GetTempPath(), "swellcast-" + Guid.NewGuid().ToString("n"));
            Directory.CreateDirectory(folder);
            return folder;
        }
    }
}
