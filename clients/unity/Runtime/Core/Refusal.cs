// Why a server refused the upgrade. The platform's WebSocket doesn't tell; `Retry-After` must be kept (PROTOCOL.md
// section 2). So the upgrade is asked for once more, by hand, and only the head of the answer is read.
using System;
using System.Globalization;
using System.IO;
using System.Net.Security;
using System.Net.Sockets;
using System.Text;

namespace Swellcast
{
    internal static class Refusal
    {
        private const int MostBytes = 1 << 14;
        private const int LongestS = 3600;

        /// <summary>What the server says; the reason that is known where it says nothing.</summary>
        public static StreamException Explain(Uri uri, int patienceMs, StreamException known)
        {
            string head;
            try
            {
                head = Head(uri, patienceMs);
            }
            catch (Exception)
            {
                return known; // nobody there, or nobody who answers
            }
            string[] lines = head.Split('\n');
            string[] first = lines[0].Trim().Split(new[] { ' ' }, 3);
            int status;
            bool http = first.Length >= 2 && first[0].StartsWith("HTTP/1.", StringComparison.Ordinal);
            if (!http || !int.TryParse(first[1], NumberStyles.None, CultureInfo.InvariantCulture, out status)) return known;
            if (status == 101) return known;
            return new StreamException("the server refuses the stream with " + status, RetryAfter(lines));
        }

        private static int RetryAfter(string[] lines)
        {
            foreach (string line in lines)
            {
                int colon = line.IndexOf(':');
                if (colon < 0 || !line.Substring(0, colon).Equals("retry-after", StringComparison.OrdinalIgnoreCase)) continue;
                int seconds;
                string value = line.Substring(colon + 1).Trim();
                bool good = int.TryParse(value, NumberStyles.None, CultureInfo.InvariantCulture, out seconds);
                return good ? Math.Min(LongestS, seconds) : 0;
            }
            return 0;
        }

        /// <summary>The head of the answer, to its empty line.</summary>
        private static string Head(Uri uri, int patienceMs)
        {
            using (var client = new TcpClient())
            {
                IAsyncResult connecting = client.BeginConnect(uri.DnsSafeHost, uri.Port, null, null);
                if (!connecting.AsyncWaitHandle.WaitOne(patienceMs)) throw new IOException("no connection");
                client.EndConnect(connecting);
                client.SendTimeout = client.ReceiveTimeout = patienceMs;
                Stream stream = client.GetStream();
                if (uri.Scheme == "wss")
                {
                    var secure = new SslStream(stream);
                    secure.AuthenticateAsClient(uri.DnsSafeHost);
                    stream = secure;
                }
                string request = "GET " + uri.PathAndQuery + " HTTP/1.1\r\nHost: " + uri.Authority
                    + "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: "
                    + Convert.ToBase64String(Guid.NewGuid().ToByteArray()) + "\r\nSec-WebSocket-Protocol: "
                    + Wire.Subprotocol + "\r\n\r\n";
                byte[] bytes = Encoding.ASCII.GetBytes(request);
                stream.Write(bytes, 0, bytes.Length);
                return ReadHead(stream, patienceMs);
            }
        }

        private static string ReadHead(Stream stream, int patienceMs)
        {
            var bytes = new byte[MostBytes];
            int began = Environment.TickCount, count = 0;
            // A byte now and then must not keep us: the time is of the whole head.
            while (count < bytes.Length && unchecked(Environment.TickCount - began) < patienceMs)
            {
                int read = stream.Read(bytes, count, bytes.Length - count);
                if (read == 0) break;
                count += read;
                string head = Encoding.ASCII.GetString(bytes, 0, count);
                int end = head.IndexOf("\r\n\r\n", StringComparison.Ordinal);
                if (end >= 0) return head.Substring(0, end);
            }
            throw new IOException("no whole head");
        }
    }
}
