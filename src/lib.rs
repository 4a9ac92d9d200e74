//! Swellcast
