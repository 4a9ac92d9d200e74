//! One integration binary; each module says which laws it holds.

mod api;
mod changes;
mod client;
mod control;
mod cpu;
mod demand;
mod engine;
mod ensemble;
mod foam;
mod frames;
#[cfg(feature = "gpu")]
mod gpu;
mod hostile;
mod laws;
mod layering;
mod models;
mod normals;
mod plan;
mod points;
mod probe;
mod probe_served;
mod properties;
mod random;
mod relayout;
mod relayout_frames;
mod relayout_served;
mod restart;
mod scenes;
mod served;
mod stability;
mod statistics;
mod streaming;
mod support;
mod trochoid;
mod vectors;
mod wire;
