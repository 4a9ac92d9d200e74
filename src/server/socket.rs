//! One accepted connection: its seat, bytes that HTTP read too many, and the watch over a peer that takes nothing.

use std::io::{self, IoSlice};
use std::pin::Pin;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use bytes::{Buf, Bytes};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::{Sleep, sleep};

use super::seats::Seat;
use super::transport::Transport;

/// A peer that takes no byte during two checks in a row is gone: 10 to 15 seconds.
const CHECK: Duration = Duration::from_secs(5);

/// A connection that ends when its peer stalls. The same type under HTTP and WebSocket.
#[derive(Debug)]
pub struct Socket {
    stream: Transport,
    _seat: Seat,
    unread: Bytes,
    written: u64,
    stall: Option<Stall>,
    /// A stall is told, and ends nothing here.
    tells: bool,
    stalled: bool,
}

/// One timer per socket that ever had to wait. It runs on through progress, so that a busy socket never resets it.
#[derive(Debug)]
struct Stall {
    timer: Pin<Box<Sleep>>,
    written: u64,
    checks: u32,
}

impl Socket {
    /// Wraps an accepted connection.
    pub fn new(stream: Transport, seat: Seat) -> Self {
        Self { stream, _seat: seat, unread: Bytes::new(), written: 0, stall: None, tells: false, stalled: false }
    }

    /// Puts back bytes that were read past the end of HTTP.
    pub fn unread(mut self, bytes: Bytes) -> Self {
        self.unread = bytes;
        self
    }

    /// From now on a stall is an error no more: [`Socket::stalled`] tells of it, and whoever asks ends the connection.
    pub fn tell_of_stalls(&mut self) {
        self.tells = true;
    }

    /// The peer has taken nothing for too long.
    pub fn stalled(&self) -> bool {
        self.stalled
    }

    fn wrote(&mut self, cx: &mut Context<'_>, result: Poll<io::Result<usize>>) -> Poll<io::Result<usize>> {
        match result {
            Poll::Ready(Ok(n)) => {
                self.written += n as u64;
                self.stalled = false;
                Poll::Ready(Ok(n))
            }
            Poll::Ready(Err(error)) => Poll::Ready(Err(error)),
            Poll::Pending => self.watch(cx),
        }
    }

    /// Called when the peer can't take more: an error when that has lasted too long.
    fn watch(&mut self, cx: &mut Context<'_>) -> Poll<io::Result<usize>> {
        let written = self.written;
        let stall = self.stall.get_or_insert_with(|| Stall { timer: Box::pin(sleep(CHECK)), written, checks: 0 });
        loop {
            ready!(stall.timer.as_mut().poll(cx));
            stall.checks = if stall.written == written { stall.checks + 1 } else { 0 };
            if stall.checks > 1 {
                self.stalled = true;
                if self.tells {
                    return Poll::Pending;
                }
                return Poll::Ready(Err(io::Error::new(io::ErrorKind::TimedOut, "the peer takes no bytes")));
            }
            stall.written = written;
            stall.timer.set(sleep(CHECK));
        }
    }
}

impl AsyncRead for Socket {
    fn poll_read(self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        let socket = self.get_mut();
        if socket.unread.is_empty() {
            return Pin::new(&mut socket.stream).poll_read(cx, buf);
        }
        let n = socket.unread.len().min(buf.remaining());
        buf.put_slice(&socket.unread[..n]);
        socket.unread.advance(n);
        Poll::Ready(Ok(()))
    }
}

impl AsyncWrite for Socket {
    fn poll_write(self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &[u8]) -> Poll<io::Result<usize>> {
        let socket = self.get_mut();
        let result = Pin::new(&mut socket.stream).poll_write(cx, buf);
        socket.wrote(cx, result)
    }

    fn poll_write_vectored(
        self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bufs: &[IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let socket = self.get_mut();
        let result = Pin::new(&mut socket.stream).poll_write_vectored(cx, bufs);
        socket.wrote(cx, result)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.get_mut().stream).poll_flush(cx)
    }

    fn poll_shutdown(self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.get_mut().stream).poll_shutdown(cx)
    }
}
