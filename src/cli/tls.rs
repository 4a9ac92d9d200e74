//! TLS on the command line: which certificate, and how people reach a server that has one.

use std::net::{IpAddr, SocketAddr, UdpSocket};
use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::{Args, ValueEnum};
use qrcode::QrCode;
use qrcode::render::unicode::Dense1x2;

use crate::server::Identity;

#[derive(Debug, Args)]
pub struct TlsArguments {
    /// Speak TLS with a certificate of the server's own: headsets' browsers allow VR over nothing less. With `serve --data`
    /// it is kept there; its files are removed to have another one made, for another address say
    #[arg(long, env = "SWELLCAST_TLS", value_enum, conflicts_with_all = ["tls_cert", "tls_key"])]
    tls: Option<Made>,
    /// Speak TLS with this certificate, or chain, in PEM
    #[arg(long, env = "SWELLCAST_TLS_CERT", value_name = "FILE", requires = "tls_key")]
    tls_cert: Option<PathBuf>,
    /// Key of the certificate, in PEM
    #[arg(long, env = "SWELLCAST_TLS_KEY", value_name = "FILE", requires = "tls_cert")]
    tls_key: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Made {
    /// Nobody vouches for it: browsers ask once whether to go on
    SelfSigned,
}

impl TlsArguments {
    /// The certificate that was asked for; one of the server's own is kept in the folder, if there is one.
    ///
    /// # Errors
    /// When it can't be read, made or kept.
    pub fn identity(&self, folder: Option<&Path>) -> Result<Option<Identity>> {
        if let (Some(certificate), Some(key)) = (&self.tls_cert, &self.tls_key) {
            return Ok(Some(Identity::from_files(certificate, key)?));
        }
        if self.tls.is_none() {
            return Ok(None);
        }
        let mut names = vec!["localhost".to_owned(), "127.0.0.1".to_owned(), "::1".to_owned()];
        names.extend(lan_address().map(|address| address.to_string()));
        Ok(Some(match folder {
            Some(folder) => Identity::kept(folder, names)?,
            None => Identity::self_signed(names)?,
        }))
    }
}

/// What people who want in are told: addresses, fingerprint, and a code for a headset's camera where it may be drawn.
pub fn told(identity: &Identity, address: SocketAddr, drawn: bool) -> String {
    let mut text = format!("The certificate's SHA-256 is {}\n", identity.fingerprint());
    if address.ip().is_loopback() {
        return text + "Only this machine can connect; --listen 0.0.0.0:8443 lets headsets in.\n";
    }
    let host = if address.ip().is_unspecified() { lan_address().unwrap_or(address.ip()) } else { address.ip() };
    let url = format!("https://{}/", SocketAddr::new(host, address.port()));
    text += &format!("Headsets on this network: {url}\n");
    if let Some(code) = QrCode::new(&url).ok().filter(|_| drawn) {
        text += &code.render::<Dense1x2>().build();
        text.push('\n');
    }
    text
}

/// The address that this machine has on its network. Nothing is sent: the system only says which way it would go.
fn lan_address() -> Option<IpAddr> {
    let socket = UdpSocket::bind("0.0.0.0:0").ok()?;
    // Of a network that is kept for examples.
    socket.connect("192.0.2.1:9").ok()?;
    socket.local_addr().ok().map(|address| address.ip()).filter(|address| !address.is_unspecified())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whoever_wants_in_is_told_how() {
        let identity = Identity::self_signed(vec!["localhost".to_owned()]).unwrap();
        let near = told(&identity, "127.0.0.1:8443".parse().unwrap(), true);
        assert!(near.contains(&identity.fingerprint()) && near.contains("--listen"), "{near}");
        let far = told(&identity, "192.0.2.7:8443".parse().unwrap(), true);
        assert!(far.contains("https://192.0.2.7:8443/") && far.lines().count() > 10, "{far}");
        assert_eq!(told(&identity, "192.0.2.7:8443".parse().unwrap(), false).lines().count(), 2);
        assert_eq!(identity.fingerprint().len(), 32 * 3 - 1);
    }
}
