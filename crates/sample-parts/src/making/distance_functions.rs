//! Solids by signed distance functions (mm, negative inside): unions and cuts that would be hard to build exactly.

use glam::{DVec2, DVec3};

/// Signed distance, or a bound of it, from a point in mm; negative inside.
pub(crate) type DistanceFunction = Box<dyn Fn(DVec3) -> f64>;

/// A cylinder around the segment `from to` with flat ends.
pub(super) fn cylinder_distance(from: DVec3, to: DVec3, radius: f64) -> DistanceFunction {
    let (length, axis) = ((to - from).length(), (to - from).normalize());
    Box::new(move |p| {
        let along = (p - from).dot(axis);
        let away = (p - from - along * axis).length();
        corner_distance(DVec2::new(away - radius, (along - length / 2.0).abs() - length / 2.0))
    })
}

/// A ball.
pub(super) fn ball_distance(center: DVec3, radius: f64) -> DistanceFunction {
    Box::new(move |p| (p - center).length() - radius)
}

/// A limb: the hull of two balls at the ends of a segment, whose radius changes evenly between them.
pub(crate) fn limb_distance((from, first): (DVec3, f64), (to, last): (DVec3, f64)) -> DistanceFunction {
    let along = to - from;
    let scale = 1.0 / along.length_squared().max(1e-12);
    Box::new(move |p| {
        let share = ((p - from).dot(along) * scale).clamp(0.0, 1.0);
        (p - from - share * along).length() - (first + share * (last - first))
    })
}

/// A box between two corners.
pub(super) fn box_distance(min: DVec3, max: DVec3) -> DistanceFunction {
    let (center, half) = ((min + max) / 2.0, (max - min) / 2.0);
    Box::new(move |p| {
        let d = (p - center).abs() - half;
        d.max(DVec3::ZERO).length() + d.max_element().min(0.0)
    })
}

/// The sheet of a gyroid with a period of `period` mm, about `thickness` mm thick.
pub(super) fn gyroid_distance(period: f64, thickness: f64) -> DistanceFunction {
    let k = std::f64::consts::TAU / period;
    Box::new(move |p| {
        let (sin, cos) = ((k * p).map(f64::sin), (k * p).map(f64::cos));
        // The mean gradient over the sheet is 1.6 k.
        sin.dot(DVec3::new(cos.y, cos.z, cos.x)).abs() / (1.6 * k) - thickness / 2.0
    })
}

/// The union of the fields, with a fillet of about `blend` mm where they meet; 0 = none.
pub(crate) fn union(fields: Vec<DistanceFunction>, blend: f64) -> DistanceFunction {
    Box::new(move |p| {
        fields.iter().map(|f| f(p)).fold(f64::INFINITY, |a, b| {
            let overlap = (blend - (a - b).abs()).max(0.0);
            a.min(b) - if blend > 0.0 { overlap * overlap / (4.0 * blend) } else { 0.0 }
        })
    })
}

/// `body` without `cuts`.
pub(super) fn difference(body: DistanceFunction, cuts: Vec<DistanceFunction>) -> DistanceFunction {
    Box::new(move |p| cuts.iter().map(|f| -f(p)).fold(body(p), f64::max))
}

/// The intersection of two fields.
pub(super) fn intersection(a: DistanceFunction, b: DistanceFunction) -> DistanceFunction {
    Box::new(move |p| a(p).max(b(p)))
}

/// Distance to the quadrant in which both coordinates are negative.
fn corner_distance(d: DVec2) -> f64 {
    d.max(DVec2::ZERO).length() + d.max_element().min(0.0)
}
