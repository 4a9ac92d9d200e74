//! One plain request to a server's HTTP side: a small answer, and a connection of its own.

use std::time::Duration;

use anyhow::{Context, Result};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpStream, ToSocketAddrs};
use tokio::time::timeout;

/// How long an answer may take. Building a change of a large sea takes seconds on a busy machine.
const PATIENCE: Duration = Duration::from_secs(10);
/// Largest answer taken.
const MOST_ANSWER: u64 = 16 << 20;

/// Asks a server that is called `host`; gives the status and the body of its answer.
///
/// # Errors
/// When there is no connection, no answer in time, or something that is none.
pub async fn exchange(
    address: impl ToSocketAddrs,
    host: &str,
    method: &str,
    path: &str,
    body: &str,
) -> Result<(u16, String)> {
    let request = format!(
        "{method} {path} HTTP/1.1\r\nhost: {host}\r\nconnection: close\r\ncontent-length: {}\r\n\r\n{body}",
        body.len()
    );
    let exchange = async {
        let mut stream = TcpStream::connect(address).await?;
        stream.write_all(request.as_bytes()).await?;
        let mut answer = String::new();
        stream.take(MOST_ANSWER).read_to_string(&mut answer).await?;
        std::io::Result::Ok(answer)
    };
    let answer = timeout(PATIENCE, exchange).await.with_context(|| format!("{host} doesn't answer for 10 s"))??;
    let (head, body) = answer.split_once("\r\n\r\n").context("the answer has no end of its head")?;
    let status = head.split(' ').nth(1).and_then(|status| status.parse().ok());
    Ok((status.context("the answer has no status")?, body.to_owned()))
}
