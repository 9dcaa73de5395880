//! Marching tetrahedra: the zero surface of a field as triangles. Six tetrahedra fill each cell in the same way, so
//! that neighbours share their faces: for any field, the surface is closed and every edge has two triangles.

use glam::{DVec3, USizeVec3};

use super::{distance_functions::DistanceFunction, surface::SurfaceBuilder};

/// The corners (bits x, y, z) of the six tetrahedra of a cell, around the diagonal from 0 to 7, all right-handed.
const TETRAHEDRA: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];
/// The surface keeps this distance from the grid points, as a share of the edge, so that triangles keep an area.
const LEAST_SHARE: f64 = 0.08;
/// Number of bisection steps for a crossing: to a hundredth of an edge.
const HALVINGS: usize = 7;

/// The surface of `field` between two corners, which must both lie outside, with grid points every `spacing` mm.
pub(super) fn marching_tetrahedra(field: &DistanceFunction, min: DVec3, max: DVec3, spacing: f64) -> SurfaceBuilder {
    let cells = ((max - min) / spacing).ceil().max(DVec3::ONE).as_usizevec3();
    let points = cells + 1;
    let place = |x: usize, y: usize, z: usize| min + spacing * DVec3::new(x as f64, y as f64, z as f64);
    let at = |x: usize, y: usize, z: usize| (z * points.y + y) * points.x + x;
    let mut values = Vec::with_capacity(points.element_product());
    for (z, y, x) in grid_points(points) {
        values.push(field(place(x, y, z)));
    }
    let mut surface = SurfaceBuilder::default();
    for (z, y, x) in grid_points(cells) {
        let corner = |c: usize| (x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
        let value = |c: usize| values[at(corner(c).0, corner(c).1, corner(c).2)];
        let inside = (0..8).filter(|&c| value(c) < 0.0).count();
        if inside == 0 || inside == 8 {
            continue;
        }
        for tetrahedron in TETRAHEDRA {
            let corners = tetrahedron.map(|c| (place(corner(c).0, corner(c).1, corner(c).2), value(c)));
            add_tetrahedron(&mut surface, field, corners);
        }
    }
    surface
}

/// (z, y, x) of all points of a grid.
fn grid_points(size: USizeVec3) -> impl Iterator<Item = (usize, usize, usize)> {
    (0..size.z).flat_map(move |z| (0..size.y).flat_map(move |y| (0..size.x).map(move |x| (z, y, x))))
}

/// The piece of surface that cuts a right-handed tetrahedron of (place, value).
fn add_tetrahedron(surface: &mut SurfaceBuilder, field: &DistanceFunction, corners: [(DVec3, f64); 4]) {
    let (mut order, mut inside) = ([0, 1, 2, 3], 0);
    // Inner corners first; an odd number of swaps changes the handedness.
    let mut odd = false;
    for i in 0..4 {
        if corners[order[i]].1 < 0.0 {
            if i != inside {
                order.swap(i, inside);
                odd = !odd;
            }
            inside += 1;
        }
    }
    if odd {
        order.swap(if inside >= 2 { 0 } else { 2 }, if inside >= 2 { 1 } else { 3 });
    }
    let cut = |i: usize, j: usize| surface_crossing(field, corners[order[i]], corners[order[j]]);
    match inside {
        1 => surface.add_triangle(cut(0, 1), cut(0, 2), cut(0, 3)),
        2 => surface.add_quad(cut(0, 2), cut(0, 3), cut(1, 3), cut(1, 2)),
        3 => surface.add_triangle(cut(0, 3), cut(1, 3), cut(2, 3)),
        _ => {}
    }
}

/// The point where the surface crosses an edge; the same bits from both ends.
fn surface_crossing(field: &DistanceFunction, a: (DVec3, f64), b: (DVec3, f64)) -> DVec3 {
    let (inner, outer) = if a.1 < b.1 { (a.0, b.0) } else { (b.0, a.0) };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        *(if field(inner.lerp(outer, middle)) < 0.0 { &mut low } else { &mut high }) = middle;
    }
    inner.lerp(outer, (0.5 * (low + high)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE))
}
