//! A budget of bytes that may leave: who would be one too many is told when to come again, and then all get less.

use std::time::Duration;

use serde_json::json;
use swellcast::server::Settings;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::served::{ALL, Client, PATIENCE, SMALL, Served, unit};
use crate::support::scene;

const UPGRADE: &str = "connection: upgrade\r\nupgrade: websocket\r\nsec-websocket-version: 13\r\n\
    sec-websocket-key: AAAAAAAAAAAAAAAAAAAAAA==\r\nsec-websocket-protocol: swellcast.v1\r\n";

/// Reads on, so that all that is due can leave.
fn drain(mut client: Client) -> tokio::task::JoinHandle<u16> {
    tokio::spawn(async move { client.closed().await })
}

/// What a further client is answered.
async fn status(served: &Served) -> u16 {
    let mut stream = TcpStream::connect(served.address).await.unwrap();
    stream.write_all(format!("GET /v1/stream HTTP/1.1\r\nhost: a\r\n{UPGRADE}\r\n").as_bytes()).await.unwrap();
    let mut begin = [0; 12];
    stream.read_exact(&mut begin).await.unwrap();
    std::str::from_utf8(&begin[9..]).unwrap().parse().unwrap()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn who_does_not_fit_is_told_when_to_come_again() {
    let settings = Settings { egress_mbps: Some(20.0), ..Settings::default() };
    let served = Served::start(&scene(SMALL), settings).await;
    // Nothing is measured yet: two at ten megabits a second each.
    let mut readers = Vec::new();
    for _ in 0..2 {
        let mut client = served.client().await;
        client.subscribe(60, &["displacement"]).await;
        readers.push(drain(client));
    }
    let refused = served.http("GET", "/v1/stream", UPGRADE, "").await;
    assert_eq!((refused.status, refused.header("retry-after")), (503, Some("5")), "{refused:?}");
    assert_eq!(refused.json()["type"], "urn:swellcast:problem:egress");
    assert_eq!(served.get("/readyz").await.status, 200, "it goes on for all else");
    // They take three each: when that is seen, more fit.
    let came = async {
        while status(&served).await != 101 {
            tokio::time::sleep(Duration::from_millis(500)).await;
        }
    };
    tokio::time::timeout(PATIENCE, came).await.expect("there is room again");
    served.stop().await;
    for reader in readers {
        assert_eq!(reader.await.unwrap(), 1001);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn when_those_who_are_there_need_too_much_all_get_less() {
    let settings = Settings { egress_mbps: Some(20.0), ..Settings::default() };
    let served = Served::start(&scene(SMALL), settings).await;
    let mut first = served.client().await;
    let mut second = served.client().await;
    // Eight megabits a second each: eight channels of a thousand samples of two bytes; twice that with another class.
    let units: Vec<_> = ALL.iter().map(|group| unit(0, group)).collect();
    let mut more = units.clone();
    more.iter_mut().for_each(|unit| unit["class"] = json!("0.5mm"));
    for client in [&mut first, &mut second] {
        let units: Vec<_> = units.iter().chain(&more).collect();
        client.send(&json!({ "type": "subscribe", "id": 1, "rate_hz": 60, "units": units })).await;
        client.text("subscribed").await;
    }
    let told = tokio::time::timeout(PATIENCE, async { tokio::join!(first.text("quality"), second.text("quality")) });
    let (a, b) = told.await.expect("both are told");
    assert_eq!((&a["rate_hz"], &b["rate_hz"], &a["coarser"]), (&json!(30), &json!(30), &json!(0)));
    assert_eq!(status(&served).await, 503, "nobody else is let in");
    served.stop().await;
}
