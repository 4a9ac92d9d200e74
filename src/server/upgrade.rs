//! `GET /v1/stream`: the WebSocket handshake, and the raw connection back from HTTP.

use std::sync::Arc;

use axum::extract::{Request, State};
use axum::response::{IntoResponse, Response};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use http::{HeaderMap, HeaderName, StatusCode, header};
use hyper::upgrade::OnUpgrade;
use hyper_util::rt::TokioIo;

use super::ocean::Ocean;
use super::session;
use super::socket::Socket;
use crate::body::Problem;
use crate::wire::SUBPROTOCOL;

/// RFC 6455, section 1.3.
const GUID: &[u8] = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11";

/// When to ask again where there is no room, seconds.
const RETRY_S: u32 = 5;

/// Answers an upgrade request and starts the session on its connection.
///
/// # Errors
/// [`Problem`] for anything but a WebSocket upgrade of our subprotocol from an allowed origin.
pub async fn stream(State(ocean): State<Arc<Ocean>>, request: Request) -> Result<Response, Problem> {
    let admit = || {
        ocean.egress.admit().ok_or_else(|| {
            ocean.metrics.refused();
            let detail = "as many bytes leave this server as may; nobody else is let in";
            refuse(StatusCode::SERVICE_UNAVAILABLE, "egress", detail).retry_after(RETRY_S)
        })
    };
    let serve = Arc::clone(&ocean);
    open(request, &ocean.settings.allowed_origins, admit, |socket, admitted| session::serve(serve, socket, admitted))
}

/// Answers an upgrade request from an allowed origin that `admit` lets in, and starts `serve` on its connection.
///
/// # Errors
/// As [`stream`].
pub fn open<T, S, F>(
    mut request: Request,
    allowed_origins: &[String],
    admit: impl FnOnce() -> Result<T, Problem>,
    serve: S,
) -> Result<Response, Problem>
where
    T: Send + 'static,
    S: FnOnce(Socket, T) -> F + Send + 'static,
    F: Future<Output = ()> + Send + 'static,
{
    let headers = request.headers();
    let upgrade = has(headers, header::CONNECTION, "upgrade") && has(headers, header::UPGRADE, "websocket");
    let upgrading = request.extensions_mut().remove::<OnUpgrade>();
    let headers = request.headers();
    let (true, Some(upgrading)) = (upgrade, upgrading) else {
        let detail = "this path speaks WebSocket only (RFC 6455 over HTTP/1.1)";
        return Ok(with(
            header::UPGRADE,
            "websocket",
            refuse(StatusCode::UPGRADE_REQUIRED, "upgrade-required", detail),
        ));
    };
    if !has(headers, header::SEC_WEBSOCKET_VERSION, "13") {
        let refusal = refuse(StatusCode::UPGRADE_REQUIRED, "bad-handshake", "Sec-WebSocket-Version must be 13");
        return Ok(with(header::SEC_WEBSOCKET_VERSION, "13", refusal));
    }
    let key = headers.get(header::SEC_WEBSOCKET_KEY).map(http::HeaderValue::as_bytes).unwrap_or_default();
    if !STANDARD.decode(key).is_ok_and(|nonce| nonce.len() == 16) {
        let detail = "Sec-WebSocket-Key must be 16 bytes in base64";
        return Err(refuse(StatusCode::BAD_REQUEST, "bad-handshake", detail).at("Sec-WebSocket-Key"));
    }
    let offered = all(headers, header::SEC_WEBSOCKET_PROTOCOL);
    if !offered.split(',').any(|name| name.trim() == SUBPROTOCOL) {
        let refusal = refuse(StatusCode::BAD_REQUEST, "bad-subprotocol", "the server speaks no other subprotocol");
        return Err(refusal.at("Sec-WebSocket-Protocol").found(offered).allowed(SUBPROTOCOL));
    }
    check_origin(headers, allowed_origins)?;
    let admitted = admit()?;
    let mut hash = sha1_smol::Sha1::new();
    hash.update(key);
    hash.update(GUID);
    let accept = STANDARD.encode(hash.digest().bytes());
    tokio::spawn(take_over(upgrading, |socket| serve(socket, admitted)));
    let headers = [
        (header::CONNECTION, "upgrade"),
        (header::UPGRADE, "websocket"),
        (header::SEC_WEBSOCKET_PROTOCOL, SUBPROTOCOL),
        (header::SEC_WEBSOCKET_ACCEPT, accept.as_str()),
    ];
    Ok((StatusCode::SWITCHING_PROTOCOLS, headers).into_response())
}

async fn take_over<F: Future<Output = ()>>(upgrading: OnUpgrade, serve: impl FnOnce(Socket) -> F) {
    let Ok(upgraded) = upgrading.await else { return };
    match upgraded.downcast::<TokioIo<Socket>>() {
        // A client may have spoken before it read our answer.
        Ok(parts) => serve(parts.io.into_inner().unread(parts.read_buf)).await,
        Err(_) => tracing::error!("a stream was upgraded from a connection that is not ours"),
    }
}

/// CORS does not cover WebSockets: a page of another site may not open a stream unless its origin is allowed.
fn check_origin(headers: &HeaderMap, allowed: &[String]) -> Result<(), Problem> {
    let Some(origin) = headers.get(header::ORIGIN) else { return Ok(()) };
    let origin = origin.to_str().unwrap_or_default();
    let host = headers.get(header::HOST).and_then(|host| host.to_str().ok()).unwrap_or_default();
    let own = origin.split_once("://").is_some_and(|(_, site)| !site.is_empty() && site.eq_ignore_ascii_case(host));
    if own || allowed.iter().any(|allowed| allowed.eq_ignore_ascii_case(origin)) {
        return Ok(());
    }
    let detail = format!("pages of {origin:?} may not open a stream here");
    Err(refuse(StatusCode::FORBIDDEN, "foreign-origin", &detail).at("Origin").found(origin))
}

fn refuse(status: StatusCode, kind: &'static str, detail: &str) -> Problem {
    Problem::new(status, kind, "The stream can't be opened", detail)
}

fn with(name: HeaderName, value: &'static str, problem: Problem) -> Response {
    ([(name, value)], problem).into_response()
}

/// All values of a header, as one list.
fn all(headers: &HeaderMap, name: HeaderName) -> String {
    let values: Vec<_> = headers.get_all(name).iter().filter_map(|value| value.to_str().ok()).collect();
    values.join(",")
}

fn has(headers: &HeaderMap, name: HeaderName, token: &str) -> bool {
    all(headers, name).split(',').any(|value| value.trim().eq_ignore_ascii_case(token))
}
