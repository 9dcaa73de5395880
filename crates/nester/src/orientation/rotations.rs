//! Rotations and directions: those along axes, random ones, and those given by a solid.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DQuat, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use solids::ExtremePoints;

/// The 24 rotations that map axes onto axes; the identity comes first.
pub(crate) fn axis_rotations() -> [DQuat; 24] {
    let mut turns = [DQuat::IDENTITY; 24];
    let quarter = |axis: DVec3, n: usize| DQuat::from_axis_angle(axis, n as f64 * PI / 2.0);
    for (at, turn) in turns.iter_mut().enumerate() {
        let (up, about) = (at / 4, at % 4);
        let tip = if up < 4 { quarter(DVec3::X, up) } else { quarter(DVec3::Y, 2 * (up - 4) + 1) };
        *turn = snap_rotation(quarter(DVec3::Z, about) * tip);
    }
    turns
}

/// Quaternion components of axis rotations are 0, 1/2, sqrt(1/2) or 1. Rounding to these values keeps rotated axes
/// exact.
fn snap_rotation(turn: DQuat) -> DQuat {
    let exact = [0.0, 0.5, 0.5_f64.sqrt(), 1.0];
    let nearest = |v: f64| exact.into_iter().find(|e| (e - v.abs()).abs() < 1e-6).unwrap_or(v.abs()).copysign(v);
    DQuat::from_array(turn.to_array().map(nearest))
}

/// Decodes a rotation from three numbers in 0..1 (Shoemake's method: uniform numbers give uniform rotations).
pub(crate) fn rotation_from_genes([share, first, second]: [f64; 3]) -> DQuat {
    let (a, b) = ((1.0 - share).sqrt(), share.sqrt());
    let (sin1, cos1) = (first * TAU).sin_cos();
    let (sin2, cos2) = (second * TAU).sin_cos();
    DQuat::from_xyzw(a * sin1, a * cos1, b * sin2, b * cos2).normalize()
}

/// A random direction, uniform on the sphere.
pub(crate) fn random_direction(rng: &mut ChaCha8Rng) -> DVec3 {
    let z: f64 = rng.random_range(-1.0..1.0);
    let (sin, cos) = (rng.random::<f64>() * TAU).sin_cos();
    let flat = (1.0 - z * z).sqrt();
    DVec3::new(flat * cos, flat * sin, z)
}

/// `count` directions spread evenly over the sphere (Fibonacci lattice).
pub(crate) fn spread_directions(count: usize) -> impl Iterator<Item = DVec3> {
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |at| {
        let z = 1.0 - (2.0 * at as f64 + 1.0) / count as f64;
        let (sin, cos) = (golden * at as f64).sin_cos();
        let flat = (1.0 - z * z).sqrt();
        DVec3::new(flat * cos, flat * sin, z)
    })
}

/// The vertices that reach farthest in `count` directions: they determine a part's extents almost exactly.
pub(crate) fn extreme_points(vertices: &[DVec3], count: usize) -> Vec<DVec3> {
    if vertices.len() <= count {
        return vertices.to_vec();
    }
    let axes = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
    let chosen = ExtremePoints::new(vertices).farthest_points(axes.into_iter().chain(spread_directions(count)));
    chosen.into_iter().map(|at| vertices[at]).collect()
}

/// The principal frame of the points: the rotation that takes x, y, z onto the directions of greatest to least spread.
pub(crate) fn principal_frame(points: &[DVec3]) -> DQuat {
    let mean = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let mut spread = DMat3::ZERO;
    for &point in points {
        let arm = point - mean;
        spread += DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z);
    }
    let most = dominant_eigenvector(spread, DVec3::new(1.0, 0.37, 0.21));
    let value = most.dot(spread * most);
    let rest = spread - DMat3::from_cols(most * most.x, most * most.y, most * most.z) * value;
    let raw = dominant_eigenvector(rest, most.any_orthonormal_vector());
    let second = (raw - most * raw.dot(most)).normalize_or(most.any_orthonormal_vector());
    DQuat::from_mat3(&DMat3::from_cols(most, second, most.cross(second))).normalize()
}

/// The eigenvector of the greatest eigenvalue, by power iteration.
fn dominant_eigenvector(matrix: DMat3, start: DVec3) -> DVec3 {
    (0..60).fold(start.normalize(), |v, _| (matrix * v).normalize_or(v))
}
