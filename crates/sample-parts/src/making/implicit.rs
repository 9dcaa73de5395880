//! Parts by signed distance functions: unions with fillets and organic lattices.

use glam::DVec3;
use solids::Mesh;

use super::{
    distance_functions::{
        DistanceFunction, ball_distance, box_distance, cylinder_distance, difference, gyroid_distance, intersection,
        union,
    },
    marching_tetrahedra::marching_tetrahedra,
};

/// The solid of a field inside a box, grown by two grid steps so that the surface closes.
pub(crate) fn mesh_of_field(field: &DistanceFunction, min: DVec3, max: DVec3, spacing: f64) -> Mesh {
    // Not at round coordinates, where flat faces often lie.
    let margin = DVec3::new(2.13, 2.17, 2.11) * spacing;
    marching_tetrahedra(field, min - margin, max + margin, spacing).into_mesh()
}

/// A pipe tee: a run along x and a branch upwards, both hollow and open, mm.
pub fn pipe_tee(run_mm: f64, branch_mm: f64, outer_mm: f64, wall_mm: f64) -> Mesh {
    let (half, radius) = (run_mm / 2.0, outer_mm / 2.0);
    let tubes = |radius: f64, beyond: f64| {
        let run = cylinder_distance(DVec3::X * -(half + beyond), DVec3::X * (half + beyond), radius);
        vec![run, cylinder_distance(DVec3::ZERO, DVec3::Z * (branch_mm + beyond), radius)]
    };
    let tee = difference(union(tubes(radius, 0.0), wall_mm), tubes(radius - wall_mm, outer_mm));
    let max = DVec3::new(half, radius, branch_mm);
    mesh_of_field(&tee, DVec3::new(-half, -radius, -radius), max, wall_mm / 1.65)
}

/// A ball of a gyroid sheet, mm: one winding wall with all of its pores open.
pub fn gyroid_ball(diameter_mm: f64, period_mm: f64, sheet_mm: f64) -> Mesh {
    let radius = diameter_mm / 2.0;
    let field = intersection(gyroid_distance(period_mm, sheet_mm), ball_distance(DVec3::ZERO, radius));
    mesh_of_field(&field, DVec3::splat(-radius), DVec3::splat(radius), sheet_mm / 1.5)
}

/// Two eyes joined by a waisted rod, as in an engine, mm: distance of the eyes' centres, their diameters, the height.
pub fn connecting_rod(centers_mm: f64, big_mm: f64, small_mm: f64, height_mm: f64) -> Mesh {
    let (big, small) = (big_mm / 2.0, small_mm / 2.0);
    let (end, up) = (DVec3::X * centers_mm, DVec3::Z * height_mm);
    let waist = small * 0.5;
    let low = DVec3::new(0.0, -waist, 0.25 * height_mm);
    let high = DVec3::new(centers_mm, waist, 0.75 * height_mm);
    let body = union(
        vec![cylinder_distance(DVec3::ZERO, up, big), cylinder_distance(end, end + up, small), box_distance(low, high)],
        0.3 * small,
    );
    let bore = |at: DVec3, radius: f64| cylinder_distance(at - up, at + 2.0 * up, radius);
    let field = difference(body, vec![bore(DVec3::ZERO, 0.65 * big), bore(end, 0.55 * small)]);
    let min = DVec3::new(-big, -big, 0.0);
    mesh_of_field(&field, min, DVec3::new(centers_mm + small, big, height_mm), small_mm / 13.5)
}
