//! How a session ends: with which code, and so that the client gets to read it.

use std::time::Duration;

use futures_util::SinkExt;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::time::timeout;
use tokio_websockets::proto::ProtocolError;
use tokio_websockets::{CloseCode, Error, Message, WebSocketStream};

use super::socket::Socket;

/// How long a close may take.
const FAREWELL: Duration = Duration::from_secs(2);

/// Most that is read of a client that goes on sending, bytes.
const MOST_WASTE: usize = 1 << 20;

/// The end of a client that does not read what it must know.
pub const OVERFLOW: End = End::Close(4000, "control messages are not read");

/// The end of a client that takes nothing any more; it reads so if it wakes in time.
pub const STALLED: End = End::Close(4001, "frames are not read");

/// The end of a client whose text is none.
pub const NOT_UTF8: End = End::Close(1007, "text must be UTF-8");

/// How a session ends; without one, the connection is gone already.
#[derive(Clone, Copy, Debug)]
pub enum End {
    /// We close, and say why.
    Close(u16, &'static str),
    /// The client closes; the answer to that is on its way.
    Answer,
}

/// What an error of the connection ends it with; `None` when it is gone.
pub fn end_of(error: &Error) -> Option<End> {
    match error {
        Error::PayloadTooLong { .. } => Some(End::Close(1009, "the message is too long")),
        Error::Protocol(ProtocolError::InvalidUtf8) => Some(NOT_UTF8),
        Error::Protocol(_) => Some(End::Close(1002, "not the WebSocket protocol")),
        _ => None,
    }
}

/// Closes a connection so that the client can read why.
pub async fn part(mut stream: WebSocketStream<Socket>, end: Option<End>) {
    let Some(end) = end else { return };
    if let End::Close(code, reason) = end
        && let Ok(code) = CloseCode::try_from(code)
    {
        // Refused where the library has queued a close of its own, with the same code.
        let _ = stream.start_send_unpin(Message::close(Some(code), reason));
    }
    let polite = async {
        stream.flush().await.ok()?;
        let mut socket = stream.into_inner();
        socket.shutdown().await.ok()?;
        // Bytes left unread would turn the close into a reset, and the client would never read it.
        let mut waste = vec![0; 4096];
        let mut wasted = 0;
        while wasted < MOST_WASTE {
            wasted += socket.read(&mut waste).await.ok().filter(|read| *read > 0)?;
        }
        Some(())
    };
    let _ = timeout(FAREWELL, polite).await;
}
