//! The network side: HTTP API, stream sessions, the ring of frames they read, metrics, the embedded viewer.
//!
//! [`Ocean::start`] sets a sea under way, [`Ocean::replay`] one that was recorded; [`run`] serves it. Invariants: frames are never copied; a client costs its
//! own task and a cursor, and nothing that it does or leaves undone holds up another.

mod accuracy;
mod allowance;
mod api;
mod budget;
mod budget_beat;
mod bulletin;
mod client;
mod echo;
mod egress;
mod farewell;
mod flow;
mod flows;
mod hello;
mod latency;
mod listen;
mod metrics;
mod ocean;
mod offer;
mod pace;
mod plan;
mod player;
mod points;
mod probe;
mod process;
mod proposal;
mod quality;
mod read_body;
mod refusal;
mod repick;
mod replay;
mod requests;
mod ring;
mod seats;
mod session;
mod settings;
mod socket;
mod source;
mod stream;
mod subscriptions;
mod tls;
mod transport;
mod upgrade;
mod viewer;

pub use budget::BUDGET_MS;
#[doc(hidden)]
pub use echo::echo;
pub use latency::Latency;
pub use listen::run;
pub use ocean::Ocean;
pub use process::{Usage, allow_open_files, machine_cpu_seconds};
pub use replay::ReplaySettings;
pub use settings::{MAX_UNITS, Settings};
pub use tls::{Identity, IdentityError};
