//! One integration binary; each module says which laws it holds.

mod api;
mod changes;
mod client;
mod control;
mod cpu;
mod engine;
mod ensemble;
mod foam;
mod frames;
mod hostile;
mod laws;
mod layering;
mod models;
mod properties;
mod random;
mod restart;
mod scenes;
mod served;
mod stability;
mod statistics;
mod streaming;
mod support;
mod vectors;
mod wire;
