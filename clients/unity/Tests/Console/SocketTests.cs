// The connection against servers that are none: who refuses, says nonsense, says too much, or nothing.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.IO;
using System.Net;
using System.Net.Sockets;
using System.Security.Cryptography;
using System.Text;
using System.Threading;

namespace Swellcast.Tests
{
    internal static class SocketTests
    {
        public static void Add(Tests tests)
        {
            tests.Add("socket: 503 is told, and Retry-After kept", RetryAfter);
            tests.Add("socket: nonsense in place of an upgrade", Nonsense);
            tests.Add("socket: a server of another subprotocol", OtherProtocol);
            tests.Add("socket: fragments, pings, and a close", Fragments);
            tests.Add("socket: a message that never ends", Endless);
            tests.Add("socket: waits grow, and have a bound", Waits);
        }

        /// <summary>Serves one connection after the other by `serve`, which gets what the client sent first.</summary>
        private sealed class Server : IDisposable
        {
            private readonly TcpListener listener = new TcpListener(IPAddress.Loopback, 0);
            public int Connections;

            public Server(Action<Stream, string> serve)
            {
                listener.Start();
                var thread = new Thread(() =>
                {
                    try
                    {
                        for (;;)
                        {
                            using (TcpClient client = listener.AcceptTcpClient())
                            {
                                Interlocked.Increment(ref Connections);
                                client.ReceiveTimeout = client.SendTimeout = 5000;
                                Once(client.GetStream(), serve);
                            }
                        }
                    }
                    catch (SocketException)
                    {
                        // Stopped.
                    }
                    catch (InvalidOperationException)
                    {
                        // Stopped between two of them.
                    }
                });
                thread.IsBackground = true;
                thread.Start();
            }

            private static void Once(Stream stream, Action<Stream, string> serve)
            {
                try
                {
                    var request = new StringBuilder();
                    while (!request.ToString().EndsWith("\r\n\r\n", StringComparison.Ordinal))
                    {
                        int next = stream.ReadByte();
                        if (next < 0) return;
                        request.Append((char)next);
                    }
                    serve(stream, request.ToString());
                }
                catch (IOException)
                {
                }
            }

            public string Url { get { return "ws://127.0.0.1:" + ((IPEndPoint)listener.LocalEndpoint).Port; } }

            public void Dispose()
            {
                listener.Stop();
            }
        }

        private static void Write(Stream stream, string text)
        {
            byte[] bytes = Encoding.UTF8.GetBytes(text);
            stream.Write(bytes, 0, bytes.Length);
        }

        private static void Upgrade(Stream stream, string request, string protocol)
        {
            string key = null;
            foreach (string line in request.Split('\n'))
            {
                if (line.StartsWith("Sec-WebSocket-Key:", StringComparison.OrdinalIgnoreCase)) key = line.Substring(18).Trim();
            }
            byte[] hash;
            using (SHA1 sha = SHA1.Create())
            {
                hash = sha.ComputeHash(Encoding.ASCII.GetBytes(key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"));
            }
            Write(stream, "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                + (protocol == null ? "" : "Sec-WebSocket-Protocol: " + protocol + "\r\n")
                + "Sec-WebSocket-Accept: " + Convert.ToBase64String(hash) + "\r\n\r\n");
        }

        /// <summary>A frame of a server: no mask.</summary>
        private static void Part(Stream stream, int first, byte[] payload)
        {
            stream.WriteByte((byte)first);
            stream.WriteByte((byte)(payload.Length < 126 ? payload.Length : 126));
            if (payload.Length >= 126)
            {
                stream.WriteByte((byte)(payload.Length >> 8));
                stream.WriteByte((byte)payload.Length);
            }
            stream.Write(payload, 0, payload.Length);
        }

        private sealed class Ears : Listener
        {
            public readonly List<string> States = new List<string>();
            public readonly ManualResetEvent Frame = new ManualResetEvent(false);

            public override void OnState(bool connected, string why)
            {
                lock (States) States.Add(connected ? "connected" : why);
            }

            public override void OnFrame(Frame frame)
            {
                Frame.Set();
                throw new InvalidOperationException("a listener's own fault");
            }

            public string First(int patienceMs)
            {
                Stopwatch watch = Stopwatch.StartNew();
                while (watch.ElapsedMilliseconds < patienceMs)
                {
                    lock (States)
                    {
                        if (States.Count > 0) return States[0];
                    }
                    Thread.Sleep(10);
                }
                throw new Exception("no state within " + patienceMs + " ms");
            }
        }

        private static string FirstState(Server server, Ears ears)
        {
            using (new Connection(server.Url, new Wish(), ears)) return ears.First(15000);
        }

        private static void RetryAfter()
        {
            using (var server = new Server((stream, request) =>
                Write(stream, "HTTP/1.1 503 Service Unavailable\r\nretry-after: 2\r\nContent-Length: 0\r\n\r\n")))
            {
                var ears = new Ears();
                using (new Connection(server.Url, new Wish(), ears))
                {
                    Check.Same(ears.First(15000), "the server refuses the stream with 503", "why");
                    int before = server.Connections;
                    Thread.Sleep(1500);
                    Check.Same(server.Connections, before, "connections within 1.5 s");
                    Thread.Sleep(1500);
                    Check.That(server.Connections > before, "it comes again");
                }
            }
        }

        private static void Nonsense()
        {
            using (var server = new Server((stream, request) => Write(stream, new string('x', 100000) + "\r\n\r\n")))
            {
                FirstState(server, new Ears());
            }
            using (var server = new Server((stream, request) => Write(stream, "HTTP/1.1 404 Not Found\r\n\r\n")))
            {
                Check.Same(FirstState(server, new Ears()), "the server refuses the stream with 404", "why");
            }
        }

        private static void OtherProtocol()
        {
            using (var server = new Server((stream, request) => Upgrade(stream, request, null)))
            {
                Check.That(FirstState(server, new Ears()) != "connected", "no connection");
            }
        }

        private static void Fragments()
        {
            using (var server = new Server((stream, request) =>
            {
                Check.That(request.Contains("swellcast.v1"), "the subprotocol is asked for");
                Upgrade(stream, request, "swellcast.v1");
                byte[] hello = Encoding.UTF8.GetBytes(Samples.Hello()), frame = Samples.Frame();
                for (int at = 0; at < hello.Length; at += 100)
                {
                    var part = new byte[Math.Min(100, hello.Length - at)];
                    Array.Copy(hello, at, part, 0, part.Length);
                    Part(stream, (at == 0 ? 1 : 0) | (at + 100 >= hello.Length ? 0x80 : 0), part);
                    Part(stream, 0x89, new byte[] { 1, 2, 3 }); // a ping in between
                }
                Part(stream, 0x82, frame);
                Part(stream, 0x82, Samples.Frame(tick: 7680));
                Part(stream, 0x88, new byte[] { 0x0f, 0xa0, (byte)'n', (byte)'o' }); // 4000
                Thread.Sleep(200);
            }))
            {
                var ears = new Ears();
                using (new Connection(server.Url, new Wish(), ears))
                {
                    Check.That(ears.Frame.WaitOne(5000), "a frame came");
                    for (int i = 0; i < 200 && ears.States.Count < 2; i++) Thread.Sleep(10);
                }
                Check.Same(ears.States[0], "connected", "first");
                Check.Same(ears.States[1], "the server closed with 4000: no", "then");
            }
        }

        private static void Endless()
        {
            using (var server = new Server((stream, request) =>
            {
                Upgrade(stream, request, "swellcast.v1");
                for (int i = 0; i < 100000; i++) Part(stream, i == 0 ? 2 : 0, new byte[60000]);
            }))
            {
                string why = FirstState(server, new Ears());
                Check.Same(why, "message is above 1048576 bytes", "why");
            }
        }

        private static void Waits()
        {
            var backoff = new Backoff();
            int[] most = { 313, 625, 1250, 2500, 3750, 3750, 3750 };
            foreach (int bound in most)
            {
                int wait = backoff.NextMs(0);
                Check.That(wait <= bound && wait >= bound / 2, "wait " + wait + " of " + bound);
            }
            Check.Same(backoff.NextMs(60), 60000, "what the server wants");
            backoff.Reset();
            Check.That(backoff.NextMs(0) <= 313, "short again");
        }
    }
}
