//! One integration binary; each module says which laws it holds.

mod api;
mod changes;
mod client;
mod control;
mod cpu;
mod engine;
mod frames;
mod hostile;
mod laws;
mod layering;
mod random;
mod relayout;
mod relayout_frames;
mod relayout_served;
mod restart;
mod scenes;
mod served;
mod streaming;
mod support;
mod vectors;
mod wire;
