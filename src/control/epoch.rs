//! Identity of a timeline and the moment of its tick 0.

use std::fmt;
use std::hash::{BuildHasher, Hasher, RandomState};

use serde::{Deserialize, Serialize};

/// Which timeline this is. Another epoch is another sea.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Epoch {
    /// Random at creation.
    pub id: u64,
    /// Unix time of tick 0, nanoseconds.
    pub unix_ns: i64,
}

impl Epoch {
    /// A new timeline whose tick 0 is at `unix_ns`.
    pub fn begin(unix_ns: i64) -> Self {
        // The standard hasher is keyed by the system's randomness: no crate of our own for one number.
        let mut hasher = RandomState::new().build_hasher();
        hasher.write_i64(unix_ns);
        Self { id: hasher.finish(), unix_ns }
    }
}

impl fmt::Display for Epoch {
    /// The identity as the protocol writes it: 16 hexadecimal digits.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.id)
    }
}
