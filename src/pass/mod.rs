//! The passes in the order they run, in f32 on the CPU: evolve, transform (with its operators), assemble, foam,
//! quantise; and trochoids, which take the place of the first three where a scene asks for them.
//!
//! Invariant: a pass gives the same bits on any number of threads.

pub mod assemble;
pub mod evolve;
pub mod foam;
pub mod operator;
pub mod quantise;
pub mod transform;
pub mod trochoid;
