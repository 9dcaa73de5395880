//! Parts of constant thickness or in terraces: plates, gears, clips, hinges.

use glam::{DVec2, DVec3};

use super::{
    layers::prism,
    outline::{Outline, circle, rectangle, rounded_rectangle},
};
use crate::geometry::Mesh;

/// A box of 12 triangles from the origin, mm. Too plain for a sample of its own, handy for tests.
pub fn cuboid(size_mm: DVec3) -> Mesh {
    prism(Outline::new(rectangle(DVec2::ZERO, size_mm.truncate())), &[0.0, size_mm.z]).mesh()
}

/// A flat mounting bracket with rounded corners and a screw hole near each end, mm.
pub fn bracket(length_mm: f64, width_mm: f64, thickness_mm: f64, hole_mm: f64) -> Mesh {
    let (size, middle) = (DVec2::new(length_mm, width_mm), width_mm / 2.0);
    let mut plate = Outline::new(rounded_rectangle(DVec2::ZERO, size, width_mm / 4.0, 12));
    for x in [middle, length_mm - middle] {
        plate = plate.with_hole(circle(DVec2::new(x, middle), hole_mm / 2.0, 32, 0.0));
    }
    let levels: Vec<f64> = (0..=2).map(|i| thickness_mm * f64::from(i) / 2.0).collect();
    prism(plate, &levels).mesh()
}
