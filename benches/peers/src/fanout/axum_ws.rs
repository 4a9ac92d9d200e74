//! The same frames by axum's own WebSocket: one task a client, which waits for the next frame and sends it.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Result, bail};
use axum::Router;
use axum::extract::State;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::response::Response;
use axum::routing::get;
use axum::serve::ListenerExt;
use bytes::Bytes;
use swellcast::engine::Clock;
use swellcast::recording::{Block, Recording};
use swellcast::server::Usage;
use swellcast::tile::SentFrame;
use swellcast::wire::{
    ClientMessage, Hello, SUBPROTOCOL, ServerMessage, Subscribed, TICKS_PER_SECOND, Time, TimeAnswer,
};
use tokio::net::TcpListener;
use tokio::sync::watch;

/// What all clients share.
struct Ground {
    hello: Hello,
    clock: Clock,
    frames: watch::Receiver<(i64, Bytes)>,
}

/// Serves the tape until it is killed.
pub async fn serve(tape: &Path) -> Result<()> {
    let mut recording = Recording::open(tape)?;
    let hello = recording.preface().hello.clone();
    let clock = Clock::start(Clock::unix_now_ns());
    let (send, frames) = watch::channel((0, Bytes::new()));
    let lead = hello.lead_ticks;
    std::thread::spawn(move || -> Result<()> {
        let mut of_tape = Vec::new();
        for at in 0..recording.len() {
            if let Block::Frames { bytes, frames, .. } = recording.block(at)? {
                of_tape.extend(frames.iter().map(|(begin, end)| SentFrame::read(bytes[*begin..*end].to_vec().into())));
            }
        }
        let of_tape: Vec<SentFrame> = of_tape.into_iter().collect::<Result<_, _>>()?;
        // Rounds of two seconds, at ticks of our own clock.
        let round: Vec<&SentFrame> =
            of_tape.iter().filter(|frame| frame.tick < of_tape[0].tick + 2 * TICKS_PER_SECOND).collect();
        let mut begin = (clock.now_tick() / TICKS_PER_SECOND + 2) * TICKS_PER_SECOND;
        loop {
            for frame in &round {
                let tick = begin + frame.tick - round[0].tick;
                let later = (*frame).clone().later(tick - frame.tick);
                std::thread::sleep(clock.until(tick - lead));
                send.send((later.tick, later.bytes))?;
            }
            begin += 2 * TICKS_PER_SECOND;
        }
    });
    let ground = Arc::new(Ground { hello, clock, frames });
    let router = Router::new().route("/v1/stream", get(upgrade)).route("/metrics", get(figures)).with_state(ground);
    let listener = TcpListener::bind("127.0.0.1:0").await?;
    println!("{}", listener.local_addr()?);
    let listener = listener.tap_io(|stream| drop(stream.set_nodelay(true)));
    Ok(axum::serve(listener, router).await?)
}

async fn figures() -> String {
    let Some(Usage { cpu_seconds, resident_bytes }) = Usage::own() else { return String::new() };
    format!("process_cpu_seconds_total {cpu_seconds}\nprocess_resident_memory_bytes {resident_bytes}\n")
}

async fn upgrade(upgrade: WebSocketUpgrade, State(ground): State<Arc<Ground>>) -> Response {
    upgrade.protocols([SUBPROTOCOL]).on_upgrade(async move |socket| {
        // A client that leaves ends its own task.
        let _ = watch_over(socket, &ground).await;
    })
}

async fn watch_over(mut socket: WebSocket, ground: &Ground) -> Result<()> {
    let text = |message: ServerMessage| Message::text(message.to_json());
    socket.send(text(ServerMessage::Hello(Box::new(ground.hello.clone())))).await?;
    let (mut frames, mut wanted) = (ground.frames.clone(), false);
    frames.mark_unchanged();
    loop {
        tokio::select! {
            message = socket.recv() => {
                let Some(Ok(message)) = message else { bail!("gone") };
                let Message::Text(asked) = message else { continue };
                match ClientMessage::parse(&asked) {
                    Ok(ClientMessage::Subscribe(subscribe)) => {
                        wanted = true;
                        let (id, rate_hz, units) = (subscribe.id, subscribe.rate_hz, subscribe.units);
                        let from_tick = frames.borrow_and_update().0;
                        socket.send(text(ServerMessage::Subscribed(Subscribed { id, rate_hz, units, from_tick }))).await?;
                    }
                    Ok(ClientMessage::Time(Time { t0 })) => {
                        let now_us = ground.clock.now_us();
                        let answer = TimeAnswer { t0, t1_us: now_us, t2_us: now_us };
                        socket.send(text(ServerMessage::Time(answer))).await?;
                    }
                    _ => {}
                }
            }
            changed = frames.changed() => {
                changed?;
                let bytes = frames.borrow_and_update().1.clone();
                if wanted {
                    socket.send(Message::Binary(bytes)).await?;
                }
            }
        }
    }
}
