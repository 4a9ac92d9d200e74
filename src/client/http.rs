//! One plain request to a server's HTTP side: small answers, no connection kept.

use std::time::Duration;

use anyhow::{Context, Result, bail};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::timeout;

/// How long an answer may take.
const PATIENCE: Duration = Duration::from_secs(10);
/// Largest answer taken.
const MOST_ANSWER: u64 = 16 << 20;

/// Asks for a path of the server at `address` (host and port); gives the status and the body.
///
/// # Errors
/// When there is no connection, no answer in time, or something that is none.
pub async fn get(address: &str, path: &str) -> Result<(u16, String)> {
    let exchange = async {
        let mut stream = TcpStream::connect(address).await.with_context(|| format!("can't connect to {address}"))?;
        let request = format!("GET {path} HTTP/1.1\r\nhost: {address}\r\nconnection: close\r\n\r\n");
        stream.write_all(request.as_bytes()).await?;
        let mut answer = String::new();
        stream.take(MOST_ANSWER).read_to_string(&mut answer).await?;
        let (head, body) = answer.split_once("\r\n\r\n").context("the server's answer is no HTTP")?;
        let status = head.split(' ').nth(1).and_then(|status| status.parse().ok());
        Ok((status.context("the server's answer has no status")?, body.to_owned()))
    };
    match timeout(PATIENCE, exchange).await {
        Ok(done) => done,
        Err(_) => bail!("{address} does not answer {path} within 10 s"),
    }
}
