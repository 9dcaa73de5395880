//! Sweeps outlines along a sequence of frames: straight, bent, twisted, tapered or closed.

use std::f64::consts::TAU;

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::{
    outline::{PlanarOutline, loop_edges},
    surface::SurfaceBuilder,
    triangulate::triangulate_outline,
};

/// Sweeps an outline through `frames`, each of which maps the outline's plane into space with its normal (local z)
/// along the path. Both ends get a cap.
pub(crate) fn sweep_outline(outline: &PlanarOutline, frames: &[DAffine3]) -> SurfaceBuilder {
    let mut surface = sweep_walls(outline, frames);
    let (first, last) = (frames[0], frames[frames.len() - 1]);
    for corners in triangulate_outline(outline) {
        let [a, b, c] = corners.map(|p| first.transform_point3(p.extend(0.0)));
        surface.add_triangle(a, c, b);
        let [a, b, c] = corners.map(|p| last.transform_point3(p.extend(0.0)));
        surface.add_triangle(a, b, c);
    }
    surface
}

/// Rotates a profile of (radius, z), mm, about the z axis in `n` steps; corners at radius 0 become poles.
pub(crate) fn revolve_profile(profile: Vec<DVec2>, n: usize) -> SurfaceBuilder {
    let frame = |i: usize| {
        // Backwards, because radius x z points against the rotation.
        let radial = DVec2::from_angle(-TAU * (i % n) as f64 / n as f64).extend(0.0);
        DAffine3::from_mat3(DMat3::from_cols(radial, DVec3::Z, radial.cross(DVec3::Z)))
    };
    let frames: Vec<DAffine3> = (0..=n).map(frame).collect();
    sweep_walls(&PlanarOutline::new(profile), &frames)
}

fn sweep_walls(outline: &PlanarOutline, frames: &[DAffine3]) -> SurfaceBuilder {
    let mut surface = SurfaceBuilder::default();
    for pair in frames.windows(2) {
        let place = |frame: usize, p: DVec2| pair[frame].transform_point3(p.extend(0.0));
        for (a, b) in outline.loops().flat_map(loop_edges) {
            surface.add_quad(place(0, a), place(0, b), place(1, b), place(1, a));
        }
    }
    surface
}
