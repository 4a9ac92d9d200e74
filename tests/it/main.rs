//! One integration binary; each module says which laws it holds.

mod laws;
