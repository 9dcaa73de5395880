//! Parts that follow a path: ducts, hooks, springs, knobs.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DMat3, DVec2, DVec3};
use solids::Mesh;

use crate::making::{
    outline::{PlanarOutline, circle},
    sweep::sweep_outline,
};

/// A frame at `place` with its normal along `way`, its local y towards `side`, scaled.
fn sweep_frame(place: DVec3, way: DVec3, side: DVec3, scale: f64) -> DAffine3 {
    let way = way.normalize();
    let x = side.cross(way).normalize();
    DAffine3::from_mat3_translation(scale * DMat3::from_cols(x, way.cross(x), way), place)
}

/// A path in the xz plane: up by `straight`, then an arc of `radius` towards +x through `angle` radians, then straight
/// on.
fn bend_frames(straight: f64, radius: f64, angle: f64, steps: usize, end: f64) -> Vec<DAffine3> {
    let place = |turned: f64| DVec3::new(radius * (1.0 - turned.cos()), 0.0, straight + radius * turned.sin());
    let way = |turned: f64| DVec3::new(turned.sin(), 0.0, turned.cos());
    let mut frames = vec![sweep_frame(DVec3::ZERO, DVec3::Z, DVec3::Y, 1.0)];
    let arc = (0..=steps).map(|i| angle * i as f64 / steps as f64);
    frames.extend(arc.map(|turned| sweep_frame(place(turned), way(turned), DVec3::Y, 1.0)));
    frames.push(sweep_frame(place(angle) + end * way(angle), way(angle), DVec3::Y, 1.0));
    frames
}

/// A bent pipe, open at both ends, mm: outer diameter, wall, radius of the bend, its angle in degrees, straight ends.
pub fn duct(outer_mm: f64, wall_mm: f64, bend_mm: f64, bend_degrees: f64, straight_mm: f64) -> Mesh {
    let radius = outer_mm / 2.0;
    let outline = PlanarOutline::new(circle(DVec2::ZERO, radius, 48, 0.0)).with_hole(circle(
        DVec2::ZERO,
        radius - wall_mm,
        48,
        0.0,
    ));
    sweep_outline(&outline, &bend_frames(straight_mm, bend_mm, bend_degrees.to_radians(), 18, straight_mm)).into_mesh()
}

/// A coat hook with a round foot, mm: radius of the bend, thickness of the rod, length of the shank.
pub fn hook(bend_mm: f64, rod_mm: f64, shank_mm: f64) -> Mesh {
    let way = bend_frames(shank_mm, bend_mm, 1.15 * PI, 26, 0.4 * rod_mm);
    let at_foot = |height: f64, scale: f64| sweep_frame(DVec3::Z * height, DVec3::Z, DVec3::Y, scale);
    let mut frames = vec![at_foot(0.0, 2.6), at_foot(0.5 * rod_mm, 2.6), at_foot(0.5 * rod_mm, 1.3)];
    frames.push(at_foot(0.9 * rod_mm, 1.0));
    frames.extend(&way[1..way.len() - 1]);
    // The tip is rounded.
    let (end, last) = (way[way.len() - 2], way[way.len() - 1]);
    let onward = last.translation - end.translation;
    frames.extend((1..=5).map(|i| f64::from(i) / 5.0).map(|t| {
        let shrink = (1.0 - 0.85 * t * t).sqrt();
        DAffine3::from_mat3_translation(end.matrix3 * shrink, end.translation + t * onward)
    }));
    sweep_outline(&PlanarOutline::new(circle(DVec2::ZERO, rod_mm / 2.0, 28, 0.0)), &frames).into_mesh()
}

/// A helical spring, mm: mean coil diameter, wire, pitch and number of coils.
pub fn spring(coil_mm: f64, wire_mm: f64, pitch_mm: f64, coils: f64) -> Mesh {
    let steps = (coils * 28.0) as usize;
    let frames: Vec<DAffine3> = (0..=steps)
        .map(|i| coils * TAU * i as f64 / steps as f64)
        .map(|turned| {
            let out = DVec2::from_angle(turned).extend(0.0);
            let way = DVec3::Z.cross(out) * coil_mm / 2.0 + DVec3::Z * pitch_mm / TAU;
            sweep_frame(out * coil_mm / 2.0 + DVec3::Z * pitch_mm * turned / TAU, way, out, 1.0)
        })
        .collect();
    sweep_outline(&PlanarOutline::new(circle(DVec2::ZERO, wire_mm / 2.0, 16, 0.0)), &frames).into_mesh()
}

/// A star knob with `lobes` grips and a recess in its top, mm.
pub fn knob(diameter_mm: f64, height_mm: f64, lobes: usize) -> Mesh {
    let steps = 16 * lobes;
    let outline: Vec<DVec2> = (0..steps)
        .map(|i| TAU * i as f64 / steps as f64)
        .map(|turned| DVec2::from_angle(turned) * (0.45 + 0.05 * (lobes as f64 * turned).cos()) * diameter_mm)
        .collect();
    // (height, scale): up the side, over the rim, down into the recess.
    let way = [(0.0, 0.94), (0.06, 1.0), (0.65, 1.0), (0.85, 0.96), (0.95, 0.9), (1.0, 0.8), (1.0, 0.5), (0.3, 0.42)];
    let frames: Vec<DAffine3> =
        way.iter().map(|&(z, scale)| sweep_frame(DVec3::Z * z * height_mm, DVec3::Z, DVec3::Y, scale)).collect();
    sweep_outline(&PlanarOutline::new(outline), &frames).into_mesh()
}
