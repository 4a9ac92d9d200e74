//! The passes in the order they run, in f32 on the CPU: evolve, transform (with its operators), assemble, foam.
//!
//! Invariant: a pass gives the same bits on any number of threads.

pub mod assemble;
pub mod evolve;
pub mod foam;
pub mod operator;
pub mod transform;
