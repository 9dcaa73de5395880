//! Outlines swept along a row of frames: straight, bent, twisted, tapered or all the way round.

use std::f64::consts::TAU;

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::{
    outline::{Outline, loop_edges},
    surface::Surface,
    triangulate::triangulate,
};

/// Sweeps an outline through `frames`, each of which maps the outline's plane into space with its normal (local z) along
/// the way; both ends get a cap.
pub(super) fn sweep(outline: &Outline, frames: &[DAffine3]) -> Surface {
    let mut surface = walls(outline, frames);
    let (first, last) = (frames[0], frames[frames.len() - 1]);
    for corners in triangulate(outline) {
        let [a, b, c] = corners.map(|p| first.transform_point3(p.extend(0.0)));
        surface.triangle(a, c, b);
        let [a, b, c] = corners.map(|p| last.transform_point3(p.extend(0.0)));
        surface.triangle(a, b, c);
    }
    surface
}

/// Turns a profile of (radius, z), mm, about the z axis in `n` steps; corners at radius 0 become poles.
pub(super) fn revolve(profile: Vec<DVec2>, n: usize) -> Surface {
    let frame = |i: usize| {
        // Backwards, because radius x z points against the rotation.
        let radial = DVec2::from_angle(-TAU * (i % n) as f64 / n as f64).extend(0.0);
        DAffine3::from_mat3(DMat3::from_cols(radial, DVec3::Z, radial.cross(DVec3::Z)))
    };
    let frames: Vec<DAffine3> = (0..=n).map(frame).collect();
    walls(&Outline::new(profile), &frames)
}

fn walls(outline: &Outline, frames: &[DAffine3]) -> Surface {
    let mut surface = Surface::default();
    for pair in frames.windows(2) {
        let place = |frame: usize, p: DVec2| pair[frame].transform_point3(p.extend(0.0));
        for (a, b) in outline.loops().flat_map(loop_edges) {
            surface.quad(place(0, a), place(0, b), place(1, b), place(1, a));
        }
    }
    surface
}
