//! Sends every message back, over the very layers that sessions stand on: what conformance tests talk to.

use std::future::poll_fn;
use std::io;

use axum::Router;
use axum::extract::Request;
use axum::routing::get;
use tokio::net::TcpListener;
use tokio::sync::watch;

use super::listen;
use super::seats::Seats;
use super::settings::Settings;
use super::socket::Socket;
use super::stream::Stream;
use super::transport::Transport;
use super::upgrade;

/// A conformance test opens one connection after the other.
const SEATS: usize = 16;

/// Echoes messages of up to `most` bytes, at any path, for ever.
///
/// # Errors
/// When the listener fails.
pub async fn echo(listener: TcpListener, most: usize) -> io::Result<()> {
    listen::inherit(&listener)?;
    let open = move |request: Request| async move {
        upgrade::open(request, &[], || Ok(()), move |socket, ()| serve(socket, most))
    };
    let (router, seats) = (Router::new().fallback(get(open)), Seats::new(SEATS, SEATS));
    let head = Settings::default().head;
    let (_open, closing) = watch::channel(false);
    loop {
        let (stream, address) = listener.accept().await?;
        if let Some(seat) = seats.take(address.ip()) {
            tokio::spawn(listen::speak(
                Socket::new(Transport::Plain(stream), seat),
                router.clone(),
                head,
                closing.clone(),
            ));
        }
    }
}

async fn serve(socket: Socket, most: usize) {
    let mut stream = Stream::new(socket, most);
    let end = loop {
        match poll_fn(|cx| stream.look(cx)).await {
            Ok(Some(message)) if message.is_text() || message.is_binary() => stream.send(message),
            Ok(_) => {}
            Err(end) => break end,
        }
    };
    stream.part(end).await;
}
