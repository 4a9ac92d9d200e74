//! The same sea in f64, slow and obvious: the control that every fast path is measured against. Never optimised.

mod direct;
mod foam;
mod grid;
mod lattice;
mod probe;
mod trochoid;

pub use direct::{Point, at};
pub use foam::{foam, jacobian};
pub use grid::fields;
pub use lattice::lattice;
pub use probe::{Probe, probe};
pub use trochoid::{Orbits, kepler, noise, trochoids};
