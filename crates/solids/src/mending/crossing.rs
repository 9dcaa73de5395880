//! Whether a new triangle crosses the surface, or lies upon it.

use glam::DVec3;

use crate::mesh::triangle::{CornerSpan, Triangle};

/// A new triangle is drawn in by this share, so that it does not touch the ones beside it.
const DRAWN_IN: f64 = 1e-3;
/// What is nearer crosses, mm.
const TOUCHES_MM: f64 = 1e-12;
/// Boxes that are compared at most: a second of work.
const MAX_COMPARED: usize = 1 << 31;

/// Whether one of the triangles at the places `new` crosses another one of the surface. `None` = there are too many to tell.
pub(super) fn has_crossing(vertices: &[DVec3], triangles: &[[u32; 3]], new: std::ops::Range<usize>) -> Option<bool> {
    let corners = |at: usize| triangles[at].map(|corner| vertices[corner as usize]);
    let drawn_in = |at: usize| {
        let corners = corners(at);
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        (at, Triangle::new(corners.map(|corner| corner.lerp(middle, DRAWN_IN))))
    };
    let has_area = |(_, triangle): &(usize, Triangle)| triangle.normal != DVec3::ZERO;
    let mut added: Vec<(CornerSpan, (usize, Triangle))> =
        new.map(drawn_in).filter(has_area).map(|triangle| (triangle.1.corner_span(), triangle)).collect();
    if added.len().saturating_mul(triangles.len()) > MAX_COMPARED {
        return None;
    }
    added.sort_by(|one, other| one.0.0.x.total_cmp(&other.0.0.x));
    let widest = added.iter().map(|((low, high), _)| high.x - low.x).fold(0.0, f64::max);
    let crosses = |at: usize| {
        let other = Triangle::new(corners(at));
        let (low, high) = other.corner_span();
        let begin = added.partition_point(|((least, _), _)| least.x < low.x - widest);
        added[begin..].iter().take_while(|((least, _), _)| least.x <= high.x).any(|((least, most), (own, triangle))| {
            *own != at
                && least.cmple(high).all()
                && most.cmpge(low).all()
                && triangle.distance_sq_below(&other, 1.0) <= TOUCHES_MM * TOUCHES_MM
        })
    };
    Some((0..triangles.len()).any(crosses))
}
