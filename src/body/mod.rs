//! Bodies of the HTTP API, read into what they ask for, or refused; pure. Whether the sea can is decided by the server.

mod change;
mod fields;
mod probe;
mod problem;
mod told;
mod when;

pub use change::ChangeBody;
pub use fields::{Fields, missing, unreadable};
pub use probe::ProbeBody;
pub use problem::Problem;
pub use when::When;
