//! Limits of the server; every default stands here.

use std::time::Duration;

use super::tls::Identity;
use crate::engine::EngineSettings;

/// What an operator may set.
#[derive(Clone, Debug)]
pub struct Settings {
    /// How the engine runs.
    pub engine: EngineSettings,
    /// Most connections of any kind; a further one is answered 503 and closed.
    pub connections: usize,
    /// Most connections from one address.
    pub connections_per_address: usize,
    /// Most stream clients; a further one is closed with 1013.
    pub clients: usize,
    /// Most megabits of frames that may leave in a second; `None`: as many as there are.
    pub egress_mbps: Option<f64>,
    /// Milliseconds that a step may take, where the layout of cascades is to be picked by that.
    pub budget_ms: Option<f64>,
    /// With what it speaks TLS; `None`: it doesn't.
    pub tls: Option<Identity>,
    /// Most units encoded for all clients together.
    pub live_units: usize,
    /// Most points that all clients together follow.
    pub live_points: usize,
    /// Origins, as browsers write them, that may open a stream besides the server's own.
    pub allowed_origins: Vec<String>,
    /// Most bytes of frames kept for clients that are behind.
    pub ring_bytes: usize,
    /// How long a client has to send the head of a request, the wait for its next request included.
    pub head: Duration,
    /// A client that sends nothing, not even a pong, for this long is dropped.
    pub silence: Duration,
    /// How often a client is pinged.
    pub ping: Duration,
    /// How long a shutdown waits for connections to end.
    pub farewell: Duration,
}

impl Settings {
    /// The defaults, but for so many stream clients, who may all come from one address. Twice as many connections, so
    /// that requests get through when all are there.
    pub fn for_clients(clients: usize) -> Self {
        let usual = Self::default();
        let connections = clients.saturating_mul(2).max(usual.connections);
        let connections_per_address = clients.saturating_add(64).max(usual.connections_per_address);
        Self { clients, connections, connections_per_address, ..usual }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            engine: EngineSettings::default(),
            connections: 4096,
            connections_per_address: 2048,
            clients: 2048,
            egress_mbps: None,
            budget_ms: None,
            tls: None,
            live_units: 64,
            live_points: 10_000,
            allowed_origins: Vec::new(),
            ring_bytes: 256 << 20,
            head: Duration::from_secs(10),
            silence: Duration::from_secs(45),
            ping: Duration::from_secs(15),
            farewell: Duration::from_secs(5),
        }
    }
}

/// Most units of one subscription.
pub const MAX_UNITS: usize = 64;
