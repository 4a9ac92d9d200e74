//! Reads the body of a request, bounded in bytes and in time.

use std::time::Duration;

use axum::body::Body;
use futures_util::StreamExt;
use http::StatusCode;
use tokio::time::timeout;

use crate::body::{Problem, unreadable};

/// Largest body of a change.
pub const MAX_BODY: usize = 64 << 10;
/// Largest body of all. One that is refused is read on to here, so that its sender gets to read the answer.
pub const LARGEST_BODY: usize = 1 << 20;
/// How long a body may take.
const BODY_TIME: Duration = Duration::from_secs(10);

/// Reads a body of at most `most` bytes, no more than a megabyte.
///
/// # Errors
/// 413 for a longer one, 408 for a slow one, 400 for one that ends early.
pub async fn read_body(body: Body, most: usize) -> Result<Vec<u8>, Problem> {
    read_body_into(body, most, |_| Ok(())).await
}

/// The same where room must be had for what is held: `room` is told the bytes held before each chunk of them is kept.
///
/// # Errors
/// Those of [`read_body`], and of `room`.
pub async fn read_body_into(
    body: Body,
    most: usize,
    mut room: impl FnMut(usize) -> Result<(), Problem>,
) -> Result<Vec<u8>, Problem> {
    let read = async {
        let (mut held, mut length, mut stream) = (Vec::new(), 0, body.into_data_stream());
        while let Some(chunk) = stream.next().await {
            let chunk = chunk.map_err(|error| unreadable(format!("the body ends early: {error}")))?;
            length += chunk.len();
            if length > LARGEST_BODY {
                break;
            }
            if length <= most {
                room(length)?;
                held.extend_from_slice(&chunk);
            }
        }
        if length > most {
            let detail = format!("the body is longer than {most} bytes");
            return Err(Problem::new(StatusCode::PAYLOAD_TOO_LARGE, "body-too-large", "The body is too large", detail)
                .allowed(most));
        }
        Ok(held)
    };
    let late = |_| {
        let detail = format!("the body took longer than {} s", BODY_TIME.as_secs());
        Problem::new(StatusCode::REQUEST_TIMEOUT, "body-too-slow", "The body came too slowly", detail)
    };
    timeout(BODY_TIME, read).await.map_err(late)?
}
