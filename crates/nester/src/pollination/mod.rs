//! The pure optimiser: flower pollination over vectors of numbers. Has never heard of boxes.

mod levy;
mod pollination;

pub use pollination::{Edge, Gene, Pollination, Setup};
