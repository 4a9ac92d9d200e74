//! Echoes WebSocket messages over the server's own layers: `echo MOST_BYTES`. Says its address, ends with its input.

use std::io::{Read, Write};

use tokio::net::TcpListener;

#[tokio::main]
async fn main() -> std::io::Result<()> {
    let most = std::env::args().nth(1).and_then(|most| most.parse().ok()).expect("most bytes of a message");
    let listener = TcpListener::bind("127.0.0.1:0").await?;
    println!("{}", listener.local_addr()?);
    std::io::stdout().flush()?;
    // Whoever started it holds the other end, and lets go of it however it ends.
    let ended = tokio::task::spawn_blocking(|| std::io::stdin().read_to_end(&mut Vec::new()));
    tokio::select! {
        result = swellcast::server::echo(listener, most) => result,
        _ = ended => Ok(()),
    }
}
