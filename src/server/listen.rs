//! Accepts connections and speaks HTTP on each, until told to stop.

use std::io::{self, Read, Write};
use std::net::SocketAddr;
use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use socket2::SockRef;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio::time::{MissedTickBehavior, interval, sleep, timeout};

use super::api;
use super::ocean::Ocean;
use super::socket::Socket;
use super::transport::Transport;

/// Largest head of a request.
const MAX_HEAD: usize = 64 << 10;
/// The kernel takes no more than this of what the network has not: a client that stalls is found at once, and a
/// frame that has become stale is not already on its way. One small frame.
#[cfg(target_os = "linux")]
const NOT_SENT: u32 = 128 << 10;
/// What a connection above the caps is told.
const FULL: &[u8] = b"HTTP/1.1 503 Service Unavailable\r\ncontent-type: application/problem+json\r\n\
    retry-after: 5\r\nconnection: close\r\ncontent-length: 120\r\n\r\n\
    {\"type\":\"urn:swellcast:problem:full\",\"title\":\"The server is full\",\"status\":503,\
    \"detail\":\"too many connections are open\"}";

/// Serves a sea on a listener until `shutdown` resolves; then tells every client, and waits a little for them.
///
/// # Errors
/// When the listener's options can't be set. Later errors of single connections end those alone.
pub async fn run(listener: TcpListener, ocean: Arc<Ocean>, shutdown: impl Future<Output = ()>) -> io::Result<()> {
    inherit(&listener)?;
    let router = api::router(Arc::clone(&ocean));
    tokio::select! {
        () = shutdown => {}
        () = accept(&listener, &router, &ocean) => {}
        () = count_seconds(&ocean) => {}
    }
    drop(listener);
    ocean.bulletin.close();
    ocean.budget.stop();
    ocean.settle().await;
    if timeout(ocean.settings.farewell, ocean.seats.empty()).await.is_err() {
        tracing::warn!(connections = ocean.seats.taken(), "some connections did not end in time");
    }
    Ok(())
}

/// Sets the options that accepted connections inherit.
pub(super) fn inherit(listener: &TcpListener) -> io::Result<()> {
    let options = SockRef::from(listener);
    options.set_tcp_nodelay(true)?;
    #[cfg(target_os = "linux")]
    options.set_tcp_notsent_lowat(NOT_SENT)?;
    Ok(())
}

/// The server's pulse: each second, every client is told how the sea is.
async fn count_seconds(ocean: &Arc<Ocean>) {
    let mut seconds = interval(Duration::from_secs(1));
    seconds.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        // A change of backend is told at once.
        let on_time = tokio::select! {
            _ = seconds.tick() => true,
            () = ocean.backend_changed.notified() => false,
        };
        ocean.refresh_status().await;
        if on_time {
            ocean.bulletin.beat();
            ocean.egress.beat(ocean.clock.now_us(), ocean.metrics.bytes_sent(), ocean.clients());
        } else {
            ocean.bulletin.wake();
        }
        ocean.note_time().await;
        ocean.retire().await;
        if on_time {
            ocean.budget_beat();
        }
        ocean.probes.rest(ocean.tick());
    }
}

async fn accept(listener: &TcpListener, router: &Router, ocean: &Arc<Ocean>) {
    loop {
        match listener.accept().await {
            Ok((stream, address)) => welcome(stream, address, router, ocean),
            Err(error) if is_of_one_connection(&error) => {}
            Err(error) => {
                // Out of file descriptors, most likely: those in use are given back in time.
                tracing::warn!(%error, "accept");
                sleep(Duration::from_millis(100)).await;
            }
        }
    }
}

fn is_of_one_connection(error: &io::Error) -> bool {
    use io::ErrorKind::{ConnectionAborted, ConnectionRefused, ConnectionReset};
    matches!(error.kind(), ConnectionAborted | ConnectionRefused | ConnectionReset)
}

fn welcome(stream: TcpStream, address: SocketAddr, router: &Router, ocean: &Arc<Ocean>) {
    let Some(seat) = ocean.seats.take(address.ip()) else {
        ocean.metrics.refused();
        // In plain words only to those who speak plainly.
        if ocean.settings.tls.is_none() {
            refuse(stream);
        }
        return;
    };
    let (router, closing, head) = (router.clone(), ocean.bulletin.closing(), ocean.settings.head);
    let Some(tls) = &ocean.settings.tls else {
        tokio::spawn(speak(Socket::new(Transport::Plain(stream), seat), router, head, closing));
        return;
    };
    let handshake = tls.acceptor().accept(stream);
    tokio::spawn(async move {
        match timeout(head, handshake).await {
            Ok(Ok(stream)) => {
                speak(Socket::new(Transport::Sealed(Box::new(stream)), seat), router, head, closing).await;
            }
            Ok(Err(error)) => tracing::debug!(%error, "handshake"),
            Err(_) => tracing::debug!("a handshake took too long"),
        }
    });
}

/// Says that the server is full, without waiting for anything.
fn refuse(stream: TcpStream) {
    // The runtime does not know yet that a new connection can be written to; the system does.
    let Ok(mut stream) = stream.into_std() else { return };
    // A request that is here already would, unread, turn our answer into a reset.
    let _ = stream.read(&mut [0; 4096]);
    let _ = stream.write(FULL);
}

/// HTTP/1.1 on one connection. HTTP/2 is left out: no client needs it, and a stream takes a connection of its own.
pub(super) async fn speak(socket: Socket, router: Router, head: Duration, mut closing: watch::Receiver<bool>) {
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(head).max_buf_size(MAX_HEAD);
    let service = TowerToHyperService::new(router);
    let mut connection = pin!(http.serve_connection(TokioIo::new(socket), service).with_upgrades());
    let done = tokio::select! {
        done = connection.as_mut() => Some(done),
        _ = closing.wait_for(|closing| *closing) => None,
    };
    let result = match done {
        Some(result) => result,
        None => {
            connection.as_mut().graceful_shutdown();
            connection.await
        }
    };
    if let Err(error) = result {
        tracing::debug!(%error, "connection");
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_refusal_says_its_own_length() {
        let text = std::str::from_utf8(super::FULL).unwrap();
        let (head, body) = text.split_once("\r\n\r\n").unwrap();
        assert!(head.contains(&format!("content-length: {}", body.len())), "{}", body.len());
        assert!(serde_json::from_str::<serde_json::Value>(body).is_ok());
    }
}
