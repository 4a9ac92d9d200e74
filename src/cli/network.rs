//! What every server on the network has in common: its address, its limits, its log, and how it is told to end.

use std::io::{IsTerminal, Write};
use std::net::SocketAddr;
use std::path::Path;

use anyhow::{Context, Result};
use clap::Args;
use tokio::net::TcpListener;

use super::tls::{self, TlsArguments};
use crate::server::{Identity, Settings, allow_open_files};

#[derive(Debug, Args)]
pub struct NetworkArguments {
    /// Address to listen at
    #[arg(long, env = "SWELLCAST_LISTEN", default_value = "127.0.0.1:8080")]
    listen: SocketAddr,
    /// Most stream clients; from one address, too
    #[arg(long, env = "SWELLCAST_CLIENTS", default_value_t = 2048, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    clients: u32,
    /// Most megabits of frames that may leave in a second: above it nobody is let in, and then all get less
    #[arg(long, env = "SWELLCAST_EGRESS_MBPS", value_name = "MBPS", value_parser = megabits)]
    egress_mbps: Option<f64>,
    /// An origin that may open a stream beside the server's own, like https://show.example; may be repeated
    #[arg(long, value_name = "ORIGIN")]
    allow_origin: Vec<String>,
    #[command(flatten)]
    tls: TlsArguments,
}

fn megabits(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| (1.0..=1e7).contains(number));
    number.ok_or_else(|| "must be a number from 1 to 1e7".to_owned())
}

impl NetworkArguments {
    /// Listens.
    ///
    /// # Errors
    /// When the address is in use, or not ours.
    pub async fn listener(&self) -> Result<TcpListener> {
        TcpListener::bind(self.listen).await.with_context(|| format!("listening at {}", self.listen))
    }

    /// The limits asked for, and the certificate, whose folder is that of the log.
    ///
    /// # Errors
    /// When there is no such certificate.
    pub fn settings(&self, folder: Option<&Path>) -> Result<Settings> {
        Ok(Settings {
            tls: self.tls.identity(folder)?,
            allowed_origins: self.allow_origin.clone(),
            egress_mbps: self.egress_mbps,
            ..Settings::for_clients(self.clients as usize)
        })
    }
}

/// Says that a server is there, and how to get in.
pub fn tell(what: &str, address: SocketAddr, identity: Option<&Identity>, more: &str) {
    let scheme = if identity.is_some() { "https" } else { "http" };
    let mut output = std::io::stdout().lock();
    let drawn = output.is_terminal();
    let tls = identity.map(|identity| tls::told(identity, address, drawn)).unwrap_or_default();
    let said =
        write!(output, "Swellcast serves {what} at {scheme}://{address}/\n{more}{tls}").and_then(|()| output.flush());
    if let Err(error) = said {
        // Whoever started it may have stopped reading; the sea goes on.
        tracing::debug!(%error, %address, "standard output");
    }
}

/// A socket for each connection, and a few files.
pub fn allow_files(settings: &Settings) {
    let wanted = settings.connections as u64 + 64;
    match allow_open_files(wanted) {
        Ok(allowed) if allowed >= wanted => {}
        Ok(allowed) => tracing::warn!(allowed, wanted, "the system allows too few open files for all connections"),
        Err(error) => tracing::warn!(%error, "asking how many files may be open"),
    }
}

/// Logs to standard error, as much as RUST_LOG says.
pub fn log() {
    let filter = tracing_subscriber::EnvFilter::try_from_default_env().unwrap_or_else(|_| "info".into());
    tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).init();
}

/// Resolves at Ctrl-C or, where there is one, the signal to terminate.
pub async fn interrupted() {
    let ctrl_c = tokio::signal::ctrl_c();
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        if let Ok(mut terminate) = signal(SignalKind::terminate()) {
            tokio::select! {
                _ = ctrl_c => {}
                _ = terminate.recv() => {}
            }
            return;
        }
    }
    // Without a handler there is nothing to wait for but the other signal.
    let _ = ctrl_c.await;
}
