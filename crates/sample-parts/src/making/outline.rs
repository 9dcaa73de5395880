//! Plane outlines with holes: the basis of extruded and swept parts.

use std::f64::consts::TAU;

use glam::DVec2;

/// A plane region: a counter-clockwise outer loop and clockwise holes.
#[derive(Debug, Clone)]
pub(crate) struct PlanarOutline {
    pub(crate) outer: Vec<DVec2>,
    pub(super) holes: Vec<Vec<DVec2>>,
}

impl PlanarOutline {
    /// A region without holes; the loop may have either orientation.
    pub(crate) fn new(mut outer: Vec<DVec2>) -> Self {
        if signed_area(&outer) < 0.0 {
            outer.reverse();
        }
        Self { outer, holes: Vec::new() }
    }

    /// Cuts a loop that lies inside the region.
    pub(crate) fn with_hole(mut self, mut hole: Vec<DVec2>) -> Self {
        if signed_area(&hole) > 0.0 {
            hole.reverse();
        }
        self.holes.push(hole);
        self
    }

    /// All loops, the region to the left of each.
    pub(super) fn loops(&self) -> impl Iterator<Item = &[DVec2]> {
        std::iter::once(self.outer.as_slice()).chain(self.holes.iter().map(Vec::as_slice))
    }

    /// Directed edges of all loops, the region to the left of each.
    pub(super) fn edges(&self) -> impl Iterator<Item = (DVec2, DVec2)> {
        self.loops().flat_map(loop_edges)
    }

    /// Area, mm2.
    #[cfg(test)]
    pub(crate) fn area(&self) -> f64 {
        self.loops().map(signed_area).sum()
    }
}

/// Directed edges of a closed loop.
pub(super) fn loop_edges(points: &[DVec2]) -> impl Iterator<Item = (DVec2, DVec2)> {
    points.iter().copied().zip(points.iter().copied().cycle().skip(1))
}

/// Area of a loop, mm2, positive when it runs counter-clockwise.
pub(super) fn signed_area(points: &[DVec2]) -> f64 {
    loop_edges(points).map(|(a, b)| a.perp_dot(b)).sum::<f64>() / 2.0
}

/// A regular polygon with `n` corners; the first corner is at `start` turns from the x axis.
pub(crate) fn circle(center: DVec2, radius: f64, n: usize, start: f64) -> Vec<DVec2> {
    (0..n).map(|i| center + radius * DVec2::from_angle(TAU * (start + i as f64 / n as f64))).collect()
}

/// Points of an arc from one angle to another (radians), both ends included, in `n` steps.
pub(crate) fn arc(center: DVec2, radius: f64, from: f64, to: f64, n: usize) -> Vec<DVec2> {
    (0..=n).map(|i| center + radius * DVec2::from_angle(from + (to - from) * i as f64 / n as f64)).collect()
}

/// A rectangle between two corners.
pub(crate) fn rectangle(min: DVec2, max: DVec2) -> Vec<DVec2> {
    vec![min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)]
}

/// A rectangle between two corners with rounded corners, `n` steps each.
pub(crate) fn rounded_rectangle(min: DVec2, max: DVec2, radius: f64, n: usize) -> Vec<DVec2> {
    let (low, high) = (min + radius, max - radius);
    let quarter = TAU / 4.0;
    let centers = [high, DVec2::new(low.x, high.y), low, DVec2::new(high.x, low.y)];
    let corner = |i: usize| arc(centers[i], radius, i as f64 * quarter, (i + 1) as f64 * quarter, n);
    (0..4).flat_map(corner).collect()
}

/// A path drawn with a pen `width` mm wide and flat ends; the width is constant around corners.
pub(crate) fn stroke_path(path: &[DVec2], width: f64) -> PlanarOutline {
    let last = path.len() - 1;
    let direction = |i: usize| (path[i + 1] - path[i]).normalize();
    let side = |i: usize| {
        let (before, after) = (direction(i.max(1) - 1), direction(i.min(last - 1)));
        let miter = (before.perp() + after.perp()).normalize();
        miter * (width / 2.0 / miter.dot(after.perp()))
    };
    let right = (0..=last).map(|i| path[i] - side(i));
    let left = (0..=last).rev().map(|i| path[i] + side(i));
    PlanarOutline::new(right.chain(left).collect())
}
