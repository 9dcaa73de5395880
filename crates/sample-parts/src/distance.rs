//! Solids by signed distance (mm, negative inside): unions and cuts that would be hard to sew exactly.

use glam::{DVec2, DVec3};

/// Signed distance, or a bound of it, from a point in mm; negative inside.
pub(super) type Field = Box<dyn Fn(DVec3) -> f64>;

/// A cylinder around the segment `from to` with flat ends.
pub(super) fn rod(from: DVec3, to: DVec3, radius: f64) -> Field {
    let (length, axis) = ((to - from).length(), (to - from).normalize());
    Box::new(move |p| {
        let along = (p - from).dot(axis);
        let away = (p - from - along * axis).length();
        corner_distance(DVec2::new(away - radius, (along - length / 2.0).abs() - length / 2.0))
    })
}

/// A ball.
pub(super) fn ball(center: DVec3, radius: f64) -> Field {
    Box::new(move |p| (p - center).length() - radius)
}

/// A box between two corners.
pub(super) fn block(min: DVec3, max: DVec3) -> Field {
    let (center, half) = ((min + max) / 2.0, (max - min) / 2.0);
    Box::new(move |p| {
        let d = (p - center).abs() - half;
        d.max(DVec3::ZERO).length() + d.max_element().min(0.0)
    })
}

/// The sheet of a gyroid of so many mm per period, about `thickness` mm thick.
pub(super) fn gyroid(period: f64, thickness: f64) -> Field {
    let k = std::f64::consts::TAU / period;
    Box::new(move |p| {
        let (sin, cos) = ((k * p).map(f64::sin), (k * p).map(f64::cos));
        // The gradient is 1.6 k in the mean over the sheet.
        sin.dot(DVec3::new(cos.y, cos.z, cos.x)).abs() / (1.6 * k) - thickness / 2.0
    })
}

/// All of the fields together, with a fillet of about `blend` mm where they meet; 0 = none.
pub(super) fn union(fields: Vec<Field>, blend: f64) -> Field {
    Box::new(move |p| {
        fields.iter().map(|f| f(p)).fold(f64::INFINITY, |a, b| {
            let overlap = (blend - (a - b).abs()).max(0.0);
            a.min(b) - if blend > 0.0 { overlap * overlap / (4.0 * blend) } else { 0.0 }
        })
    })
}

/// `body` less all of `cuts`.
pub(super) fn cut(body: Field, cuts: Vec<Field>) -> Field {
    Box::new(move |p| cuts.iter().map(|f| -f(p)).fold(body(p), f64::max))
}

/// What two fields share.
pub(super) fn common(a: Field, b: Field) -> Field {
    Box::new(move |p| a(p).max(b(p)))
}

/// Distance to the quarter plane below both coordinates' zero.
fn corner_distance(d: DVec2) -> f64 {
    d.max(DVec2::ZERO).length() + d.max_element().min(0.0)
}
