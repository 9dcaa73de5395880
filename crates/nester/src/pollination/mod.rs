//! A pure optimiser: flower pollination over vectors of numbers. It knows nothing about geometry.

mod flower_pollination;
mod levy;

pub use flower_pollination::{FlowerPollination, GeneBoundary, GeneRange, PollinationSettings};
