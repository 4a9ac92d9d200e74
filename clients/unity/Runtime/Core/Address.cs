// The address of the stream, from what people type.
using System;

namespace Swellcast
{
    public static class Address
    {
        /// <summary>
        /// Takes http, https, ws and wss, or none of them; a URL without a path leads to `/v1/stream`.
        /// </summary>
        /// <exception cref="ArgumentException">It can't be used.</exception>
        public static Uri Of(string url)
        {
            string rest = (url ?? "").Trim(), scheme = "ws";
            int colon = rest.IndexOf("://", StringComparison.Ordinal);
            if (colon >= 0)
            {
                string given = rest.Substring(0, colon).ToLowerInvariant();
                rest = rest.Substring(colon + 3);
                scheme = given == "http" || given == "ws" ? "ws" : given == "https" || given == "wss" ? "wss" : null;
            }
            rest = rest.TrimEnd('/');
            Uri uri = null;
            bool good = scheme != null && rest.Length > 0 && Uri.TryCreate(scheme + "://" + rest, UriKind.Absolute, out uri);
            if (!good || uri.Host.Length == 0)
            {
                throw new ArgumentException("url is \"" + url + "\", must be like http://host:port or ws://host:port");
            }
            if (uri.AbsolutePath.Length > 1) return uri;
            return new Uri(uri, "/v1/stream");
        }
    }
}
