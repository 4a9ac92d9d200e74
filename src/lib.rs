//! Swellcast simulates one spectral ocean and streams it, in sync, to many thin clients.
//!
//! Data flows one way through the modules, in the order they stand here; ARCHITECTURE.md tells the story.

pub mod wire;

pub mod scene;

pub mod sea;

pub mod plan;

pub mod pass;

pub mod backend;

pub mod reference;

pub mod tile;

pub mod engine;

pub mod body;

#[cfg(feature = "server")]
pub mod accuracy;

#[cfg(feature = "server")]
pub mod control;

#[cfg(feature = "server")]
pub mod recording;

#[cfg(feature = "server")]
pub mod server;

#[cfg(feature = "server")]
pub mod client;

#[cfg(feature = "server")]
pub mod load;

#[cfg(feature = "server")]
pub mod cli;
