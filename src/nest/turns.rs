//! Rotations: which ones a rule allows, which ones are worth trying first, and the random ones.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DQuat, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{Orientation, OrientationRule};
use crate::geometry::{Bounds, Extremes};

/// The 24 rotations that map axes onto axes; the identity comes first.
pub(crate) fn axis_turns() -> [DQuat; 24] {
    let mut turns = [DQuat::IDENTITY; 24];
    let quarter = |axis: DVec3, n: usize| DQuat::from_axis_angle(axis, n as f64 * PI / 2.0);
    for (at, turn) in turns.iter_mut().enumerate() {
        let (up, about) = (at / 4, at % 4);
        let tip = if up < 4 { quarter(DVec3::X, up) } else { quarter(DVec3::Y, 2 * (up - 4) + 1) };
        *turn = snap(quarter(DVec3::Z, about) * tip);
    }
    turns
}

/// Quaternion components of axis turns are 0, 1/2, sqrt(1/2) or 1; rounding to those keeps turned axes exact.
fn snap(turn: DQuat) -> DQuat {
    let exact = [0.0, 0.5, 0.5_f64.sqrt(), 1.0];
    let nearest = |v: f64| exact.into_iter().find(|e| (e - v.abs()).abs() < 1e-6).unwrap_or(v.abs()).copysign(v);
    DQuat::from_array(turn.to_array().map(nearest))
}

/// The rotation that three numbers in 0..1 stand for (Shoemake's method: even numbers give even rotations).
pub(crate) fn turn_of_genes([share, first, second]: [f64; 3]) -> DQuat {
    let (a, b) = ((1.0 - share).sqrt(), share.sqrt());
    let (sin1, cos1) = (first * TAU).sin_cos();
    let (sin2, cos2) = (second * TAU).sin_cos();
    DQuat::from_xyzw(a * sin1, a * cos1, b * sin2, b * cos2).normalize()
}

/// A direction drawn evenly from the sphere.
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

/// The vertices that reach farthest in `count` directions: they decide a part's extents, all but exactly.
pub(crate) fn extreme_points(vertices: &[DVec3], count: usize) -> Vec<DVec3> {
    if vertices.len() <= count {
        return vertices.to_vec();
    }
    let axes = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
    let chosen = Extremes::new(vertices).among(axes.into_iter().chain(spread_directions(count)));
    chosen.into_iter().map(|at| vertices[at]).collect()
}

/// A frame along the spread of the points: the rotation that takes x, y, z onto the directions of most to least spread.
pub(crate) fn principal_frame(points: &[DVec3]) -> DQuat {
    let mean = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let mut spread = DMat3::ZERO;
    for &point in points {
        let arm = point - mean;
        spread += DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z);
    }
    let most = dominant(spread, DVec3::new(1.0, 0.37, 0.21));
    let value = most.dot(spread * most);
    let rest = spread - DMat3::from_cols(most * most.x, most * most.y, most * most.z) * value;
    let raw = dominant(rest, most.any_orthonormal_vector());
    let second = (raw - most * raw.dot(most)).normalize_or(most.any_orthonormal_vector());
    DQuat::from_mat3(&DMat3::from_cols(most, second, most.cross(second))).normalize()
}

/// The eigenvector of the greatest eigenvalue, by power iteration.
fn dominant(matrix: DMat3, start: DVec3) -> DVec3 {
    (0..60).fold(start.normalize(), |v, _| (matrix * v).normalize_or(v))
}

/// Rotations worth trying when a part is first placed, lowest first: axes onto axes of the mesh's frame and of its
/// smallest box (`frame`), as far as the rule allows them and the room holds them.
pub(crate) fn first_turns(
    orientation: &Orientation,
    frame: DQuat,
    points: &[DVec3],
    room: DVec3,
    most: usize,
) -> Vec<DQuat> {
    let candidates: Vec<DQuat> = match orientation.rule {
        OrientationRule::Fixed => vec![DQuat::IDENTITY],
        OrientationRule::Axis => axis_turns().to_vec(),
        OrientationRule::Upright => upright_turns(points),
        OrientationRule::Free => {
            let along = axis_turns().map(|turn| turn * frame.conjugate());
            let skew = along.iter().map(|a| a.angle_between(DQuat::IDENTITY)).fold(f64::INFINITY, f64::min);
            if skew < 1e-3 { axis_turns().to_vec() } else { along.into_iter().chain(axis_turns()).collect() }
        }
    };
    let candidates = if orientation.tilts.is_empty() { candidates } else { tilted(orientation, candidates, points) };
    let size = |turn: DQuat| Bounds::around(points.iter().map(|&p| turn * p)).size();
    let mut ranked: Vec<(f64, DQuat)> = (candidates.into_iter().map(|turn| (size(turn), turn)))
        .filter(|(size, _)| size.cmple(room).all())
        .map(|(size, turn)| ((size.z * 1e4).round(), turn))
        .collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Of the lowest ones all, of the others a spread over all heights: nothing but flat parts wastes the gaps.
    let lowest = ranked.len().min(most / 2);
    let others = ranked.len() - lowest;
    let wanted = others.min(most - lowest);
    let spread = (0..wanted).map(|at| lowest + at * others / wanted.max(1));
    (0..lowest).chain(spread).map(|at| ranked[at].1).collect()
}

/// Rotations brought to what the tilts let be, each once; where they may turn freely, also the least rectangle seen from
/// above of the way up nearest to the mesh's own.
fn tilted(orientation: &Orientation, candidates: Vec<DQuat>, points: &[DVec3]) -> Vec<DQuat> {
    let mut turns: Vec<DQuat> = Vec::with_capacity(candidates.len());
    let mut own: Vec<DQuat> = Vec::new();
    if let (OrientationRule::Free, Some(way)) = (orientation.rule, orientation.nearest(DQuat::IDENTITY)) {
        let stood: Vec<DVec3> = points.iter().map(|&p| way * p).collect();
        own = upright_turns(&stood).into_iter().map(|about| (about * way).normalize()).collect();
    }
    for turn in candidates.into_iter().chain(own).filter_map(|turn| orientation.nearest(turn)) {
        if turns.iter().all(|known| known.angle_between(turn) > 1e-3) {
            turns.push(turn);
        }
    }
    turns
}

/// Quarter turns about z of the mesh as it is and of its least rectangle seen from above.
fn upright_turns(points: &[DVec3]) -> Vec<DQuat> {
    let area = |yaw: f64| {
        let size = Bounds::around(points.iter().map(|&p| DQuat::from_rotation_z(yaw) * p)).size();
        size.x * size.y
    };
    let best = (0..180).map(|half| f64::from(half) * PI / 360.0).min_by(|&a, &b| area(a).total_cmp(&area(b)));
    let quarters = |yaw: f64| (0..4).map(move |n| DQuat::from_rotation_z(yaw + f64::from(n) * PI / 2.0));
    let skewed = best.filter(|&yaw| area(yaw) < 0.98 * area(0.0));
    skewed.into_iter().flat_map(quarters).chain(quarters(0.0)).collect()
}
