//! What accuracy costs: the laws of each axis, the report, and what is claimed of a stream.

mod claim;
mod laws;
mod page;
