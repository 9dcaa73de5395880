//! Turned parts (lathe): a profile rotated about the z axis.

use std::f64::consts::FRAC_PI_2;

use glam::DVec2;
use solids::Mesh;

use crate::making::{
    outline::{arc, rectangle, stroke_path},
    sweep::revolve_profile,
};

/// Steps around the axis.
const STEPS: usize = 96;

/// A flat ring by outer and inner diameter and height, mm.
pub fn ring(outer_mm: f64, inner_mm: f64, height_mm: f64) -> Mesh {
    let profile = rectangle(DVec2::new(inner_mm / 2.0, 0.0), DVec2::new(outer_mm / 2.0, height_mm));
    revolve_profile(profile, STEPS).into_mesh()
}

/// A belt pulley with a V groove, a hub on one side and a bore, mm.
pub fn pulley(outer_mm: f64, width_mm: f64, bore_mm: f64) -> Mesh {
    let (outer, bore) = (outer_mm / 2.0, bore_mm / 2.0);
    let groove = outer - 0.45 * width_mm;
    let hub = bore + 0.4 * (groove - bore);
    let at = |radius: f64, share: f64| DVec2::new(radius, share * width_mm);
    let profile = vec![
        at(bore, 0.0),
        at(outer, 0.0),
        at(outer, 0.15),
        at(groove, 0.42),
        at(groove, 0.58),
        at(outer, 0.85),
        at(outer, 1.0),
        at(hub, 1.0),
        at(hub, 1.5),
        at(bore, 1.5),
    ];
    revolve_profile(profile, STEPS).into_mesh()
}

/// A hollow cone, open above and below, mm.
pub fn lampshade(low_mm: f64, high_mm: f64, height_mm: f64, wall_mm: f64) -> Mesh {
    let path: Vec<DVec2> = (0..=6)
        .map(|i| f64::from(i) / 6.0)
        .map(|t| DVec2::new((low_mm + t * t.sqrt() * (high_mm - low_mm)) / 2.0, t * height_mm))
        .collect();
    revolve_profile(stroke_path(&path, wall_mm).outer, STEPS).into_mesh()
}

/// A pawn as on a chess board, by base diameter and height, mm.
pub fn pawn(base_mm: f64, height_mm: f64) -> Mesh {
    let (radius, head) = (base_mm / 2.0, 0.27 * base_mm);
    let neck = 0.45 * head;
    let at = |r: f64, z: f64| DVec2::new(r * radius, z * height_mm);
    let mut profile = vec![DVec2::ZERO, at(1.0, 0.0), at(1.0, 0.06), at(0.86, 0.09), at(0.9, 0.13), at(0.62, 0.2)];
    profile.extend((1..=8).map(|i| f64::from(i) / 8.0).map(|t| {
        let waist = 0.62 * radius + (neck - 0.62 * radius) * (1.0 - (1.0 - t).powi(2));
        DVec2::new(waist, (0.2 + 0.42 * t) * height_mm)
    }));
    profile.extend([at(0.55, 0.64), at(0.55, 0.67)]);
    let center = DVec2::new(0.0, height_mm - head);
    profile.extend(arc(center, head, -1.1, FRAC_PI_2, 20).into_iter().take(20));
    profile.push(DVec2::new(0.0, height_mm));
    revolve_profile(profile, 64).into_mesh()
}
