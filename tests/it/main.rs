//! One integration binary; each module says which laws it holds.

mod cpu;
mod laws;
mod support;
