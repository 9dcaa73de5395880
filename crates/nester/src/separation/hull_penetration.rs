//! How far two parts reach into each other's convex hulls, and the shortest direction out. Parts whose hulls do not
//! overlap are never interlocked.

use glam::{Mat3, Vec3};

use super::separation_step::CollisionProxy;
use crate::orientation::rotations::spread_directions;

/// Number of directions tried in each part's own frame.
const DIRECTIONS: usize = 40;
/// Hulls are moved further apart than necessary by this, mm: the extreme points are not exactly the hull.
const SPARE_MM: f32 = 0.2;

/// The overlap of two hulls.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HullPenetration {
    /// The shortest direction out for the first part, a unit vector.
    pub(crate) direction: Vec3,
    /// The distance to move in that direction, mm.
    pub(crate) depth: f32,
    /// Surface area that the overlap is weighted with, mm2.
    pub(crate) area: f32,
}

/// The directions that are tried in each part's own frame, spread over the sphere, beside the axes of its smallest box.
pub(crate) fn tried_directions() -> Vec<Vec3> {
    spread_directions(DIRECTIONS).map(|direction| direction.as_vec3()).collect()
}

/// The overlap of two parts' hulls, along the best of both parts' own directions and of the line between their middles; `spread`
/// are [`tried_directions`].
pub(crate) fn hull_penetration(
    one: &CollisionProxy,
    other: &CollisionProxy,
    spread: &[Vec3],
) -> Option<HullPenetration> {
    let apart = one.center - other.center;
    let least = smaller_radius(one, other);
    let mut best: Option<(f32, Vec3)> = None;
    for direction in own_directions(one, spread).chain(own_directions(other, spread)).chain(apart.try_normalize()) {
        // Test both signs of the direction and use the shorter one.
        let (low1, high1) = extent_along(one, direction);
        let (low2, high2) = extent_along(other, direction);
        for (depth, direction) in [(high2 - low1, direction), (high1 - low2, -direction)] {
            if best.is_none_or(|(shortest, _)| depth < shortest) {
                best = Some((depth, direction));
            }
        }
        if best.is_some_and(|(depth, _)| depth <= -SPARE_MM) {
            return None;
        }
    }
    best.map(|(depth, direction)| HullPenetration { direction, depth: depth + SPARE_MM, area: 0.5 * least * least })
}

/// The axes of a part's smallest box and the spread directions, rotated with the part.
fn own_directions<'a>(proxy: &'a CollisionProxy, spread: &'a [Vec3]) -> impl Iterator<Item = Vec3> + 'a {
    let axes = Mat3::from_quat(proxy.shape.frame.as_quat());
    let axes = [axes.x_axis, axes.y_axis, axes.z_axis];
    axes.into_iter().chain(spread.iter().copied()).map(|direction| proxy.rotation * direction)
}

pub(crate) fn smaller_radius(one: &CollisionProxy, other: &CollisionProxy) -> f32 {
    one.shape.radius_mm.min(other.shape.radius_mm) as f32
}

/// The least and greatest extent of a part along a direction.
fn extent_along(proxy: &CollisionProxy, direction: Vec3) -> (f32, f32) {
    let (own, middle) = (proxy.rotation.transpose() * direction, proxy.center.dot(direction));
    let reaches = proxy.shape.extremes_f32.iter().map(|p| p.dot(own));
    let (low, high) = reaches.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), at| (l.min(at), h.max(at)));
    (middle + low, middle + high)
}
