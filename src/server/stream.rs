//! A WebSocket on an accepted connection: how long a message may be, how it is read while it is written, how it ends.
//!
//! Sessions and the echo of the conformance tests are both this, so that what is tested is what is served.

use std::task::{Context, Poll};

use futures_util::{SinkExt, StreamExt};
use tokio_websockets::{Limits, Message, ServerBuilder, WebSocketStream};

use super::farewell::{End, NOT_UTF8, STALLED, end_of, part};
use super::socket::Socket;

/// Most pongs that wait for the socket; until they are out, no more is read.
const PONGS: u32 = 16;

/// One connection after its handshake.
pub struct Stream {
    stream: WebSocketStream<Socket>,
    flushing: bool,
    pongs: u32,
}

impl Stream {
    /// Takes a connection over from HTTP. Messages of more than `most` bytes are refused as soon as their length is
    /// known.
    pub fn new(mut socket: Socket, most: usize) -> Self {
        // An error of the socket would be the end of the stream, with nothing said.
        socket.tell_of_stalls();
        let limits = Limits::default().max_payload_len(Some(most));
        let stream = ServerBuilder::new().limits(limits).serve(socket);
        Self { stream, flushing: false, pongs: 0 }
    }

    /// Something that was sent is not with the system yet.
    pub fn flushing(&self) -> bool {
        self.flushing
    }

    /// Queues a message.
    pub fn send(&mut self, message: Message) {
        // Fails only after a close, which the next look reports.
        let _ = self.stream.start_send_unpin(message);
        self.flushing = true;
    }

    /// Polls both directions; both wake this task. Without a message, all is flushed; an error is the end.
    pub fn look(&mut self, cx: &mut Context<'_>) -> Poll<Result<Option<Message>, Option<End>>> {
        let mut flushed = false;
        if self.flushing {
            match self.stream.poll_flush_unpin(cx) {
                Poll::Ready(result) => {
                    result.map_err(|_| None)?;
                    (self.flushing, self.pongs, flushed) = (false, 0, true);
                }
                Poll::Pending => {}
            }
        }
        if self.flushing && self.pongs >= PONGS {
            let stalled = self.stream.get_ref().stalled();
            return if stalled { Poll::Ready(Err(Some(STALLED))) } else { Poll::Pending };
        }
        match self.stream.poll_next_unpin(cx) {
            Poll::Ready(Some(Ok(message))) if message.is_close() => Poll::Ready(Err(Some(End::Answer))),
            Poll::Ready(Some(Ok(message))) => {
                // The library looks at the text of a frame, and so not at one that an empty last frame cuts short:
                // its own `as_text` would make that a string all the same.
                if message.is_text() && str::from_utf8(message.as_payload()).is_err() {
                    return Poll::Ready(Err(Some(NOT_UTF8)));
                }
                if message.is_ping() {
                    // The library has queued the pong.
                    self.pongs += 1;
                    self.flushing = true;
                }
                Poll::Ready(Ok(Some(message)))
            }
            Poll::Ready(Some(Err(error))) => Poll::Ready(Err(end_of(&error))),
            Poll::Ready(None) => Poll::Ready(Err(None)),
            Poll::Pending if flushed => Poll::Ready(Ok(None)),
            // Told once, and by no waker: whichever of the two has tried to write.
            Poll::Pending if self.stream.get_ref().stalled() => Poll::Ready(Err(Some(STALLED))),
            Poll::Pending => Poll::Pending,
        }
    }

    /// Ends the connection so that the client can read why.
    pub async fn part(self, end: Option<End>) {
        part(self.stream, end).await;
    }
}
