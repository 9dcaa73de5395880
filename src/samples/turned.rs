//! Parts from the lathe: a profile turned about the z axis.

use glam::DVec2;

use super::{outline::rectangle, sweep::revolve};
use crate::geometry::Mesh;

/// A flat ring by outer and inner diameter and height, mm.
pub fn ring(outer_mm: f64, inner_mm: f64, height_mm: f64) -> Mesh {
    let profile = rectangle(DVec2::new(inner_mm / 2.0, 0.0), DVec2::new(outer_mm / 2.0, height_mm));
    revolve(profile, 96).mesh()
}
