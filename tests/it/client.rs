//! The thin client: its clock and playback as laws, its connection against servers of every manner.

mod clock;
mod connection;
mod live;
mod picture;
mod playback;
