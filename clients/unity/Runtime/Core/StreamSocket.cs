// A WebSocket to the server, with bounds on time and size. The platform's own does the framing; it is driven from one
// thread, which never waits longer than it says.
using System;
using System.Net.WebSockets;
using System.Text;
using System.Threading;
using System.Threading.Tasks;

namespace Swellcast
{
    internal sealed class StreamSocket : ISender, IDisposable
    {
        /// <summary>Longest message that is taken: the largest frame, and more than any hello.</summary>
        public const int MostBytes = 1 << 20;
        private const int FirstBytes = 1 << 16;
        /// <summary>How long the upgrade may take, and reading what is sent.</summary>
        private const int PatienceMs = 5000;

        private readonly ClientWebSocket socket = new ClientWebSocket();
        private readonly UTF8Encoding strict = new UTF8Encoding(false, true);
        private Task<WebSocketReceiveResult> pending;
        private byte[] outgoing = new byte[1024];
        private int begun; // bytes of a message of which more comes

        /// <summary>The message that came last; the array may be longer.</summary>
        public byte[] Bytes = new byte[FirstBytes];
        public int Length { get; private set; }
        public bool IsText { get; private set; }

        /// <exception cref="StreamException">There is no connection, and why.</exception>
        public static StreamSocket Open(Uri uri)
        {
            var opened = new StreamSocket();
            try
            {
                opened.Connect(uri);
                return opened;
            }
            catch (Exception error)
            {
                opened.Dispose();
                throw Refusal.Explain(uri, PatienceMs, StreamException.Of(error));
            }
        }

        private void Connect(Uri uri)
        {
            socket.Options.AddSubProtocol(Wire.Subprotocol);
            using (var cancel = new CancellationTokenSource(PatienceMs))
            {
                Task connecting = socket.ConnectAsync(uri, cancel.Token);
                // Some platforms look up names without regard to the token.
                if (!connecting.Wait(2 * PatienceMs)) throw new StreamException("connecting takes more than 5 s");
            }
            if (socket.SubProtocol != Wire.Subprotocol)
            {
                throw new StreamException("subprotocol is \"" + socket.SubProtocol + "\", must be " + Wire.Subprotocol);
            }
        }

        /// <summary>Waits for a message; true when a whole one is there.</summary>
        /// <exception cref="StreamException">The connection is over.</exception>
        public bool Receive(int waitMs)
        {
            try
            {
                for (;;)
                {
                    if (pending == null)
                    {
                        pending = socket.ReceiveAsync(Room(), CancellationToken.None);
                    }
                    if (!pending.Wait(waitMs)) return false;
                    WebSocketReceiveResult part = pending.Result;
                    pending = null;
                    if (part.MessageType == WebSocketMessageType.Close) throw Closed();
                    begun += part.Count;
                    if (!part.EndOfMessage) continue;
                    Length = begun;
                    begun = 0;
                    IsText = part.MessageType == WebSocketMessageType.Text;
                    return true;
                }
            }
            catch (Exception error)
            {
                throw StreamException.Of(error);
            }
        }

        private ArraySegment<byte> Room()
        {
            if (begun == MostBytes) throw new StreamException("message is above " + MostBytes + " bytes");
            if (begun == Bytes.Length) Array.Resize(ref Bytes, Math.Min(MostBytes, 2 * begun));
            return new ArraySegment<byte>(Bytes, begun, Bytes.Length - begun);
        }

        private StreamException Closed()
        {
            string why = socket.CloseStatusDescription;
            int code = socket.CloseStatus == null ? 1005 : (int)socket.CloseStatus.Value;
            return new StreamException("the server closed with " + code + (string.IsNullOrEmpty(why) ? "" : ": " + why));
        }

        /// <summary>The text that came last; null where it is no UTF-8.</summary>
        public string Text()
        {
            try
            {
                return strict.GetString(Bytes, 0, Length);
            }
            catch (DecoderFallbackException)
            {
                return null;
            }
        }

        /// <exception cref="StreamException">It can't be sent.</exception>
        public void Send(string text)
        {
            int most = strict.GetMaxByteCount(text.Length);
            if (outgoing.Length < most) outgoing = new byte[most];
            int count = strict.GetBytes(text, 0, text.Length, outgoing, 0);
            try
            {
                var bytes = new ArraySegment<byte>(outgoing, 0, count);
                Task sending = socket.SendAsync(bytes, WebSocketMessageType.Text, true, CancellationToken.None);
                if (!sending.Wait(PatienceMs)) throw new StreamException("the server reads nothing");
            }
            catch (Exception error)
            {
                throw StreamException.Of(error);
            }
        }

        /// <summary>Says goodbye, if that is quickly done.</summary>
        public void Close()
        {
            try
            {
                socket.CloseOutputAsync(WebSocketCloseStatus.NormalClosure, "", CancellationToken.None).Wait(500);
            }
            catch (Exception)
            {
                // It is over in any case.
            }
        }

        public void Dispose()
        {
            try
            {
                socket.Abort();
                socket.Dispose();
                // Nobody looks at what was under way; seen here so that it is not reported later.
                if (pending != null) pending.ContinueWith(task => task.Exception, TaskContinuationOptions.OnlyOnFaulted);
            }
            catch (Exception)
            {
                // It is over in any case.
            }
        }
    }
}
