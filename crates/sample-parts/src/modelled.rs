//! Parts by signed distance: unions with fillets and organic lattices.

use glam::DVec3;
use solids::Mesh;

use super::{
    distance::{Field, ball, block, common, cut, gyroid, rod, union},
    march::march,
};

/// The solid of a field inside a box, grown by two grid steps so that the surface closes.
fn model(field: &Field, min: DVec3, max: DVec3, spacing: f64) -> Mesh {
    // Off the round numbers, where flat faces like to lie.
    let margin = DVec3::new(2.13, 2.17, 2.11) * spacing;
    march(field, min - margin, max + margin, spacing).mesh()
}

/// A pipe tee: a run along x and a branch upwards, both hollow and open, mm.
pub fn pipe_tee(run_mm: f64, branch_mm: f64, outer_mm: f64, wall_mm: f64) -> Mesh {
    let (half, radius) = (run_mm / 2.0, outer_mm / 2.0);
    let tubes = |radius: f64, beyond: f64| {
        let run = rod(DVec3::X * -(half + beyond), DVec3::X * (half + beyond), radius);
        vec![run, rod(DVec3::ZERO, DVec3::Z * (branch_mm + beyond), radius)]
    };
    let tee = cut(union(tubes(radius, 0.0), wall_mm), tubes(radius - wall_mm, outer_mm));
    let max = DVec3::new(half, radius, branch_mm);
    model(&tee, DVec3::new(-half, -radius, -radius), max, wall_mm / 1.65)
}

/// A ball of a gyroid sheet, mm: one winding wall with all of its pores open.
pub fn gyroid_ball(diameter_mm: f64, period_mm: f64, sheet_mm: f64) -> Mesh {
    let radius = diameter_mm / 2.0;
    let field = common(gyroid(period_mm, sheet_mm), ball(DVec3::ZERO, radius));
    model(&field, DVec3::splat(-radius), DVec3::splat(radius), sheet_mm / 1.5)
}

/// Two eyes joined by a waisted rod, as in an engine, mm: distance of the eyes' centres, their diameters, the height.
pub fn connecting_rod(centers_mm: f64, big_mm: f64, small_mm: f64, height_mm: f64) -> Mesh {
    let (big, small) = (big_mm / 2.0, small_mm / 2.0);
    let (end, up) = (DVec3::X * centers_mm, DVec3::Z * height_mm);
    let waist = small * 0.5;
    let low = DVec3::new(0.0, -waist, 0.25 * height_mm);
    let high = DVec3::new(centers_mm, waist, 0.75 * height_mm);
    let body = union(vec![rod(DVec3::ZERO, up, big), rod(end, end + up, small), block(low, high)], 0.3 * small);
    let bore = |at: DVec3, radius: f64| rod(at - up, at + 2.0 * up, radius);
    let field = cut(body, vec![bore(DVec3::ZERO, 0.65 * big), bore(end, 0.55 * small)]);
    let min = DVec3::new(-big, -big, 0.0);
    model(&field, min, DVec3::new(centers_mm + small, big, height_mm), small_mm / 13.5)
}
