//! The project's own sample parts, made by code: for the demo, the tests and the benches. Millimetres.
//!
//! Crisp parts are built exactly, from outlines that are layered or swept; unions and lattices come from signed distances
//! and marching tetrahedra. Every sample is one closed, consistently oriented surface.

mod extruded;
mod layers;
mod outline;
mod surface;
mod sweep;
mod triangulate;
mod turned;

pub use extruded::{bracket, cuboid};
pub use turned::ring;

use crate::geometry::Mesh;

/// A sample part under the name that its file gets.
#[derive(Debug, Clone)]
pub struct Sample {
    /// File name without extension, ASCII.
    pub name: &'static str,
    /// The solid, mm.
    pub mesh: Mesh,
}

/// One sample of every kind.
pub fn all() -> Vec<Sample> {
    let sample = |name, mesh| Sample { name, mesh };
    vec![sample("ring", ring(40.0, 28.0, 8.0)), sample("bracket", bracket(60.0, 24.0, 4.0, 5.0))]
}

#[cfg(test)]
mod tests;
