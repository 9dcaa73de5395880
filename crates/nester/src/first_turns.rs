//! Rotations worth trying when a part is first placed.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use solids::Bounds;

use super::{Orientation, OrientationRule, turns::axis_turns};

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
