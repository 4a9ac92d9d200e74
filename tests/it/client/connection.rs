//! The connection against servers that this file plays: a good one, and those that lie, stall or never end.

use std::cell::Cell;
use std::future::Future;
use std::time::Duration;

use futures_util::{SinkExt, StreamExt};
use http::{HeaderValue, header::SEC_WEBSOCKET_PROTOCOL};
use swellcast::client::{Closed, ConnectError, Connection, Event};
use swellcast::tile::DecodeError;
use swellcast::wire::{
    ClientMessage, Codec, ErrorClass, FrameError, Group, SUBPROTOCOL, ServerMessage, Subscribed, TimeAnswer, UnitName,
};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio_websockets::{CloseCode, Message, ServerBuilder, WebSocketStream};

use crate::vectors::{from_later_servers, from_server, samples};

type Socket = WebSocketStream<TcpStream>;

/// Runs `client` with the URL of a server that does `serve` to its first connection.
fn against<S, C>(serve: impl FnOnce(TcpStream) -> S, client: impl FnOnce(String) -> C)
where
    S: Future<Output = ()>,
    C: Future<Output = ()>,
{
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let url = format!("http://{}", listener.local_addr().unwrap());
        let server = async {
            serve(listener.accept().await.unwrap().0).await;
            std::future::pending::<()>().await;
        };
        let client = tokio::time::timeout(Duration::from_secs(20), client(url));
        tokio::select! {
            () = server => {}
            done = client => done.expect("the client hangs"),
        }
    });
}

async fn upgraded(stream: TcpStream) -> Socket {
    let name = HeaderValue::from_static(SUBPROTOCOL);
    let builder = ServerBuilder::new().add_header(SEC_WEBSOCKET_PROTOCOL, name).unwrap();
    let (request, socket) = builder.accept(stream).await.unwrap();
    assert_eq!(request.headers().get(SEC_WEBSOCKET_PROTOCOL).unwrap(), SUBPROTOCOL);
    assert_eq!(request.uri().path(), "/v1/stream");
    socket
}

fn hello() -> String {
    from_server()[0].1.to_json()
}

fn unit() -> UnitName {
    UnitName { cascade: 0, level: 0, class: ErrorClass::Millimetre, group: Group::Foam, codec: Codec::I16 }
}

/// A clock that advances a millisecond whenever it is read.
fn counting() -> impl Fn() -> i64 {
    let us = Cell::new(0);
    move || {
        us.set(us.get() + 1000);
        us.get()
    }
}

/// Sends what a good server sends, some of it broken, then closes.
async fn play(stream: TcpStream) {
    let mut socket = upgraded(stream).await;
    socket.send(Message::text(hello())).await.unwrap();
    let mut times = 0;
    while let Some(Ok(message)) = socket.next().await {
        let Some(text) = message.as_text() else { continue };
        match ClientMessage::parse(text).unwrap() {
            ClientMessage::Points(points) => panic!("this client follows none: {points:?}"),
            ClientMessage::Report(report) => assert!(report.decode_ms >= 0.0, "{report:?}"),
            ClientMessage::Time(time) => {
                times += 1;
                let at = 5_000_000 + time.t0 as i64;
                let answer = TimeAnswer { t0: time.t0, t1_us: at, t2_us: at };
                socket.send(Message::text(ServerMessage::Time(answer).to_json())).await.unwrap();
                // An answer to no request, which must not move the clock.
                let answer = TimeAnswer { t0: -1.0, t1_us: 0, t2_us: 0 };
                socket.send(Message::text(ServerMessage::Time(answer).to_json())).await.unwrap();
                if times == 3 {
                    break;
                }
            }
            ClientMessage::Subscribe(asked) => {
                let answer = Subscribed { id: asked.id, rate_hz: asked.rate_hz, units: asked.units, from_tick: 7200 };
                socket.send(Message::text(ServerMessage::Subscribed(answer).to_json())).await.unwrap();
                for sample in samples() {
                    socket.send(Message::binary(sample.bytes())).await.unwrap();
                }
                let mut bad = samples()[0].bytes();
                bad[100] ^= 1;
                socket.send(Message::binary(bad)).await.unwrap();
                socket.send(Message::binary(vec![])).await.unwrap();
                socket.send(Message::ping("still there?")).await.unwrap();
                for (_, text, _) in from_later_servers() {
                    socket.send(Message::text(text)).await.unwrap();
                }
                socket.send(Message::text("{")).await.unwrap();
            }
        }
    }
    socket.send(Message::close(CloseCode::try_from(1001).ok(), "good night")).await.unwrap();
}

#[test]
fn everything_a_server_says_becomes_an_event() {
    against(play, async |url| {
        let mut connection = Connection::open(&url, counting()).await.unwrap();
        let Event::Hello(hello) = connection.next().await else { panic!("hello comes first") };
        assert_eq!(hello.scene, "beaufort-5");
        let id = connection.subscribe(15, vec![unit()], false).await;
        let (mut frames, mut heard) = (0, vec![]);
        let closed = loop {
            match connection.next().await {
                Event::Subscribed(subscribed) => {
                    assert_eq!((subscribed.id, subscribed.units), (id, vec![unit().into()]))
                }
                Event::Frame(tile, bytes) => {
                    let sample = &samples()[frames];
                    assert_eq!(bytes, sample.bytes());
                    let step = sample.header.step[0];
                    assert_eq!(tile.planes.len(), sample.planes.len());
                    assert!(tile.planes[0].iter().zip(&sample.planes[0]).all(|(v, c)| *v == f32::from(*c) * step));
                    frames += 1;
                }
                Event::BadFrame(DecodeError::Frame(FrameError::Crc { .. })) => heard.push("crc"),
                Event::BadFrame(DecodeError::Frame(FrameError::Short { got: 0 })) => heard.push("empty"),
                Event::BadText(_) => heard.push("text"),
                Event::Error { .. } => heard.push("error"),
                Event::Closed(closed) => break closed,
                other => panic!("{other:?}"),
            }
        };
        assert_eq!((frames, heard), (samples().len(), vec!["crc", "empty", "error", "text"]));
        assert_eq!(closed, Closed::ByServer { code: 1001, reason: "good night".to_owned() });
        assert_eq!(connection.clock().samples(), 3);
        let (now, bound) = (connection.server_us().unwrap(), connection.error_bound_us().unwrap());
        assert!((5_000_000..6_000_000).contains(&now) && bound < 100_000, "{now} +- {bound}");
        assert!(matches!(connection.next().await, Event::Closed(_)), "and nothing after the end");
    });
}

#[test]
fn who_does_not_speak_the_protocol_is_refused() {
    let refused = |serve: fn(TcpStream) -> std::pin::Pin<Box<dyn Future<Output = ()>>>, word: &'static str| {
        against(serve, async move |url| {
            let error = Connection::open(&url, counting()).await.err().expect("refused");
            assert!(matches!(error, ConnectError::Upgrade { .. }) && error.to_string().contains(word), "{error}");
        });
    };
    refused(|stream| Box::pin(async { drop(ServerBuilder::new().accept(stream).await) }), "doesn't speak");
    refused(
        |mut stream| {
            Box::pin(async move {
                let _ = stream.read(&mut [0; 1024]).await;
                let _ = stream.write_all(b"HTTP/1.1 503 Service Unavailable\r\nContent-Length: 0\r\n\r\n").await;
            })
        },
        "503",
    );
    refused(
        |mut stream| {
            Box::pin(async move {
                let mut line = b"HTTP/1.1 101 Switching Protocols\r\nX: ".to_vec();
                while stream.write_all(&line).await.is_ok() {
                    line = vec![b'a'; 4096];
                }
            })
        },
        "no end",
    );
    refused(|_| Box::pin(std::future::ready(())), "");
}

#[test]
fn nobody_there_and_wrong_urls_are_said_plainly() {
    against(
        async |_| {},
        async |_| {
            let gone = Connection::open("http://127.0.0.1:1", counting()).await.err().unwrap().to_string();
            assert_eq!(gone, "can't connect to 127.0.0.1:1");
            let wrong = Connection::open("https://127.0.0.1", counting()).await.err().unwrap().to_string();
            assert!(wrong.contains("https://127.0.0.1") && wrong.contains("http://host:port"), "{wrong}");
        },
    );
}

#[test]
fn a_silent_server_is_left() {
    // Time is an argument: ten seconds pass between two looks at it.
    let serve = async |stream| {
        let mut socket = upgraded(stream).await;
        socket.send(Message::text(hello())).await.unwrap();
        std::future::pending::<()>().await;
    };
    against(serve, async |url| {
        let us = Cell::new(0);
        let mut connection = Connection::open(&url, || us.get()).await.unwrap();
        assert!(matches!(connection.next().await, Event::Hello(_)));
        us.set(11_000_000);
        assert!(matches!(connection.next().await, Event::Closed(Closed::Silent)));
    });
}

#[test]
fn messages_too_large_and_sea_of_another_protocol_end_it() {
    let huge = async |stream| {
        let mut socket = upgraded(stream).await;
        let _ = socket.send(Message::binary(vec![0; 1 << 20])).await;
        let _ = socket.next().await;
    };
    against(huge, async |url| {
        let mut connection = Connection::open(&url, counting()).await.unwrap();
        assert!(matches!(connection.next().await, Event::Closed(Closed::Broken(_))));
    });
    let other = async |stream| {
        let mut socket = upgraded(stream).await;
        let text = hello().replace("\"protocol\":1", "\"protocol\":2");
        socket.send(Message::text(text)).await.unwrap();
    };
    against(other, async |url| {
        let mut connection = Connection::open(&url, counting()).await.unwrap();
        let Event::Closed(closed) = connection.next().await else { panic!("went on") };
        assert_eq!(closed.to_string(), "the server's protocol is 2, must be 1");
    });
}

#[test]
fn pings_without_end_from_who_reads_nothing_do_not_pile_up_pongs() {
    let flood = async |stream| {
        let mut socket = upgraded(stream).await;
        while socket.send(Message::ping(vec![7; 125])).await.is_ok() {}
    };
    against(flood, async |url| {
        let mut connection = Connection::open(&url, counting()).await.unwrap();
        let Event::Closed(closed) = connection.next().await else { panic!("an event out of pings") };
        assert!(matches!(closed, Closed::Silent | Closed::Broken(_)), "{closed}");
    });
}
