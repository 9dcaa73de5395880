//! How far two parts reach into each other's convex hulls, and which way out is the shortest: parts whose hulls stand apart
//! are never locked into each other.

use glam::{Mat3, Vec3};

use super::{push::Guide, turns::spread_directions};

/// Directions tried in each part's own frame.
const DIRECTIONS: usize = 40;
/// Hulls are brought so much further apart than they must be, mm: the outermost points are not quite the hull.
const SPARE_MM: f32 = 0.2;

/// Two hulls that overlap.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Overlap {
    /// The shortest way out for the first part, a unit vector.
    pub(crate) way: Vec3,
    /// How far it is, mm.
    pub(crate) depth: f32,
    /// Surface that this weighs like, mm2.
    pub(crate) area: f32,
}

/// The directions that are tried in each part's own frame, spread over the sphere, beside the axes of its smallest box.
pub(crate) fn tried_directions() -> Vec<Vec3> {
    spread_directions(DIRECTIONS).map(|way| way.as_vec3()).collect()
}

/// The overlap of two parts' hulls, along the best of both parts' own directions and of the line between their middles; `spread`
/// are [`tried_directions`].
pub(crate) fn overlap(one: &Guide, other: &Guide, spread: &[Vec3]) -> Option<Overlap> {
    let apart = one.place - other.place;
    let least = least_radius(one, other);
    let mut best: Option<(f32, Vec3)> = None;
    for way in own_ways(one, spread).chain(own_ways(other, spread)).chain(apart.try_normalize()) {
        // Both senses at once: the one that needs less way.
        let (low1, high1) = limits(one, way);
        let (low2, high2) = limits(other, way);
        for (depth, way) in [(high2 - low1, way), (high1 - low2, -way)] {
            if best.is_none_or(|(shortest, _)| depth < shortest) {
                best = Some((depth, way));
            }
        }
        if best.is_some_and(|(depth, _)| depth <= -SPARE_MM) {
            return None;
        }
    }
    best.map(|(depth, way)| Overlap { way, depth: depth + SPARE_MM, area: 0.5 * least * least })
}

/// The axes of a part's smallest box and the spread, as the part stands.
fn own_ways<'a>(guide: &'a Guide, spread: &'a [Vec3]) -> impl Iterator<Item = Vec3> + 'a {
    let axes = Mat3::from_quat(guide.shape.frame.as_quat());
    let axes = [axes.x_axis, axes.y_axis, axes.z_axis];
    axes.into_iter().chain(spread.iter().copied()).map(|way| guide.turn * way)
}

fn least_radius(one: &Guide, other: &Guide) -> f32 {
    one.shape.radius_mm.min(other.shape.radius_mm) as f32
}

/// How far a part reaches along a direction, back and forth.
fn limits(guide: &Guide, way: Vec3) -> (f32, f32) {
    let (own, middle) = (guide.turn.transpose() * way, guide.place.dot(way));
    let reaches = guide.shape.extremes_f32.iter().map(|p| p.dot(own));
    let (low, high) = reaches.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), at| (l.min(at), h.max(at)));
    (middle + low, middle + high)
}
