//! The same server over TLS: requests, the stream, and what it owes to those who speak plainly or not at all.

use std::sync::Arc;
use std::time::Duration;

use futures_util::{SinkExt, StreamExt};
use serde_json::{Value, json};
use swellcast::server::{Identity, Settings};
use swellcast::wire::{SUBPROTOCOL, split};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::timeout;
use tokio_rustls::TlsConnector;
use tokio_rustls::client::TlsStream;
use tokio_rustls::rustls::crypto::ring::default_provider;
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName};
use tokio_rustls::rustls::{ClientConfig, RootCertStore};
use tokio_websockets::{ClientBuilder, Message};

use crate::served::{PATIENCE, SMALL, Served};
use crate::support::scene;

fn identity() -> Identity {
    Identity::self_signed(vec!["localhost".to_owned()]).unwrap()
}

async fn start(identity: &Identity) -> Served {
    let settings = Settings { tls: Some(identity.clone()), head: Duration::from_millis(500), ..Settings::default() };
    Served::start(&scene(SMALL), settings).await
}

/// A connection of somebody who trusts this certificate alone.
async fn sealed(served: &Served, identity: &Identity) -> TlsStream<TcpStream> {
    let mut roots = RootCertStore::empty();
    roots.add(CertificateDer::from(identity.certificate().to_vec())).unwrap();
    let config = ClientConfig::builder_with_provider(Arc::new(default_provider()));
    let config = config.with_safe_default_protocol_versions().unwrap().with_root_certificates(roots);
    let connector = TlsConnector::from(Arc::new(config.with_no_client_auth()));
    let stream = TcpStream::connect(served.address).await.unwrap();
    connector.connect(ServerName::try_from("localhost").unwrap(), stream).await.expect("the certificate is trusted")
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn requests_and_the_stream_are_the_same_over_tls() {
    let identity = identity();
    let served = start(&identity).await;
    let mut stream = sealed(&served, &identity).await;
    stream.write_all(b"GET /livez HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n").await.unwrap();
    let mut answer = String::new();
    timeout(PATIENCE, stream.read_to_string(&mut answer)).await.unwrap().unwrap();
    assert!(answer.starts_with("HTTP/1.1 200") && answer.ends_with("alive\n"), "{answer}");

    let name = http::HeaderName::from_static("sec-websocket-protocol");
    let builder = ClientBuilder::new().uri("wss://localhost/v1/stream").unwrap();
    let builder = builder.add_header(name, http::HeaderValue::from_static(SUBPROTOCOL)).unwrap();
    let (mut client, _) = builder.connect_on(sealed(&served, &identity).await).await.unwrap();
    let unit = json!({ "cascade": 0, "level": 0, "class": "1mm", "group": "displacement", "codec": "rans" });
    let subscribe = json!({ "type": "subscribe", "id": 1, "rate_hz": 15, "units": [unit] });
    client.send(Message::text(subscribe.to_string())).await.unwrap();
    let (mut hello, mut frames) = (false, 0);
    while frames < 5 {
        let message = timeout(PATIENCE, client.next()).await.unwrap().unwrap().unwrap();
        if let Some(text) = message.as_text() {
            hello |= serde_json::from_str::<Value>(text).unwrap()["type"] == "hello";
        } else if message.is_binary() {
            split(message.as_payload()).unwrap();
            frames += 1;
        }
    }
    assert!(hello);
    drop(client);
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn whoever_speaks_no_tls_or_not_at_all_is_let_go() {
    let identity = identity();
    let served = start(&identity).await;
    let mut silent = TcpStream::connect(served.address).await.unwrap();
    let mut plain = TcpStream::connect(served.address).await.unwrap();
    plain.write_all(b"GET /livez HTTP/1.1\r\nhost: localhost\r\n\r\n").await.unwrap();
    for stream in [&mut plain, &mut silent] {
        let mut answer = Vec::new();
        // A reset will do, too.
        let _ = timeout(PATIENCE, stream.read_to_end(&mut answer)).await.expect("the connection ends");
        assert!(!answer.starts_with(b"HTTP"), "nothing is said in plain words");
    }
    // And others are served.
    sealed(&served, &identity).await;
    served.stop().await;
}

#[test]
fn a_certificate_comes_from_files_too_and_says_what_is_wrong_with_them() {
    let folder = tempfile::tempdir().unwrap();
    let (certificate, key) = (folder.path().join("cert.pem"), folder.path().join("key.pem"));
    let made = rcgen::generate_simple_self_signed(vec!["localhost".to_owned()]).unwrap();
    let pem = |label: &str, der: &[u8]| {
        use base64::Engine as _;
        let text = base64::engine::general_purpose::STANDARD.encode(der);
        let lines: Vec<&str> = text.as_bytes().chunks(64).map(|line| str::from_utf8(line).unwrap()).collect();
        format!("-----BEGIN {label}-----\n{}\n-----END {label}-----\n", lines.join("\n"))
    };
    std::fs::write(&certificate, pem("CERTIFICATE", made.cert.der())).unwrap();
    std::fs::write(&key, pem("PRIVATE KEY", &made.signing_key.serialize_der())).unwrap();
    let identity = Identity::from_files(&certificate, &key).unwrap();
    assert_eq!(identity.certificate(), &made.cert.der()[..]);
    for (certificate, key, named) in
        [(&key, &key, "key.pem"), (&certificate, &certificate, "cert.pem"), (&folder.path().join("none"), &key, "none")]
    {
        let error = Identity::from_files(certificate, key).unwrap_err().to_string();
        assert!(error.contains(named), "{error}");
    }
}

#[test]
fn a_certificate_that_is_kept_is_the_same_after_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let kept = || Identity::kept(folder.path(), vec!["localhost".to_owned()]);
    let first = kept().unwrap();
    assert_eq!(kept().unwrap().fingerprint(), first.fingerprint());
    let key = folder.path().join("certificate-key.der");
    #[cfg(unix)]
    assert_eq!(std::os::unix::fs::PermissionsExt::mode(&key.metadata().unwrap().permissions()) & 0o777, 0o600);
    std::fs::write(&key, b"no key").unwrap();
    let told = kept().unwrap_err().to_string();
    assert!(told.contains("certificate-key.der") && told.contains(folder.path().to_str().unwrap()), "{told}");
    std::fs::remove_file(folder.path().join("certificate.der")).unwrap();
    assert_ne!(kept().unwrap().fingerprint(), first.fingerprint(), "another is made where there is none");
}
