//! Rotations to try when a part is first placed.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use solids::Bounds;

use super::rotations::axis_rotations;
use crate::{OrientationLimits, OrientationRule};

/// Returns the rotations to try when a part is first placed, lowest first: those that map axes onto axes of the mesh's
/// frame and of its smallest box (`frame`), limited to what the rule allows and to what fits into the room.
pub(crate) fn first_rotations(
    orientation: &OrientationLimits,
    frame: DQuat,
    points: &[DVec3],
    room: DVec3,
    most: usize,
) -> Vec<DQuat> {
    let candidates: Vec<DQuat> = match orientation.rule {
        OrientationRule::Fixed => vec![DQuat::IDENTITY],
        OrientationRule::Axis => axis_rotations().to_vec(),
        OrientationRule::Upright => upright_rotations(points),
        OrientationRule::Free => {
            let along = axis_rotations().map(|turn| turn * frame.conjugate());
            let skew = along.iter().map(|a| a.angle_between(DQuat::IDENTITY)).fold(f64::INFINITY, f64::min);
            if skew < 1e-3 { axis_rotations().to_vec() } else { along.into_iter().chain(axis_rotations()).collect() }
        }
    };
    let candidates =
        if orientation.tilts.is_empty() { candidates } else { rotations_within_tilts(orientation, candidates, points) };
    let size = |turn: DQuat| Bounds::from_points(points.iter().map(|&p| turn * p)).size();
    let mut ranked: Vec<(f64, DQuat)> = (candidates.into_iter().map(|turn| (size(turn), turn)))
        .filter(|(size, _)| size.cmple(room).all())
        .map(|(size, turn)| ((size.z * 1e4).round(), turn))
        .collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Keep all of the lowest rotations, and a selection of the others over all heights: using flat parts only would
    // waste gaps.
    let lowest = ranked.len().min(most / 2);
    let others = ranked.len() - lowest;
    let wanted = others.min(most - lowest);
    let spread = (0..wanted).map(|at| lowest + at * others / wanted.max(1));
    (0..lowest).chain(spread).map(|at| ranked[at].1).collect()
}

/// Moves rotations to the nearest ones that the tilts allow, without duplicates. If rotation is free, also adds the
/// rotations with the smallest footprint for the allowed up direction nearest to the mesh's own.
fn rotations_within_tilts(orientation: &OrientationLimits, candidates: Vec<DQuat>, points: &[DVec3]) -> Vec<DQuat> {
    let mut turns: Vec<DQuat> = Vec::with_capacity(candidates.len());
    let mut own: Vec<DQuat> = Vec::new();
    if let (OrientationRule::Free, Some(rotation)) = (orientation.rule, orientation.nearest_allowed(DQuat::IDENTITY)) {
        let stood: Vec<DVec3> = points.iter().map(|&p| rotation * p).collect();
        own = upright_rotations(&stood).into_iter().map(|about| (about * rotation).normalize()).collect();
    }
    for turn in candidates.into_iter().chain(own).filter_map(|turn| orientation.nearest_allowed(turn)) {
        if turns.iter().all(|known| known.angle_between(turn) > 1e-3) {
            turns.push(turn);
        }
    }
    turns
}

/// Quarter turns about z of the mesh as it is, and of the yaw with its smallest footprint.
fn upright_rotations(points: &[DVec3]) -> Vec<DQuat> {
    let area = |yaw: f64| {
        let size = Bounds::from_points(points.iter().map(|&p| DQuat::from_rotation_z(yaw) * p)).size();
        size.x * size.y
    };
    let best = (0..180).map(|half| f64::from(half) * PI / 360.0).min_by(|&a, &b| area(a).total_cmp(&area(b)));
    let quarters = |yaw: f64| (0..4).map(move |n| DQuat::from_rotation_z(yaw + f64::from(n) * PI / 2.0));
    let skewed = best.filter(|&yaw| area(yaw) < 0.98 * area(0.0));
    skewed.into_iter().flat_map(quarters).chain(quarters(0.0)).collect()
}
