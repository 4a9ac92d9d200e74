//! The control log: which timeline this is, the scene it began with, and every change since, in one durable order.
//!
//! A sea is a function of what stands here and of the tick, so this is all that a restart needs.
//! Invariants: an entry that was acknowledged is on disk; entries count from 1 without a gap; nothing is rewritten.

mod epoch;
mod error;
mod store;

pub use epoch::Epoch;
pub use error::StoreError;
pub use store::{Answer, Begun, Key, Store};
