//! Laws of `swellcast accuracy`: what it measures, and how that is told.

mod page;
