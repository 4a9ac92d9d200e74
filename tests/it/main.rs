//! One integration binary; each module says which laws it holds.

mod changes;
mod client;
mod cpu;
mod frames;
mod laws;
mod layering;
mod random;
mod support;
mod vectors;
mod wire;
