//! Marching tetrahedra: the zero surface of a field as triangles. Six tetrahedra fill each cell in the same way, so that
//! neighbours share their faces: the surface is closed and every edge has two triangles, whatever the field.

use glam::{DVec3, USizeVec3};

use super::{distance::Field, surface::Surface};

/// The corners (bits x, y, z) of the six tetrahedra of a cell, around the diagonal from 0 to 7, all right-handed.
const TETRAHEDRA: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];
/// The surface keeps so far from the grid points, as a share of the edge: triangles keep an area.
const LEAST_SHARE: f64 = 0.08;
/// Halvings until a crossing is found: to a hundredth of an edge.
const HALVINGS: usize = 7;

/// The surface of `field` between two corners, which must both lie outside, with grid points every `spacing` mm.
pub(super) fn march(field: &Field, min: DVec3, max: DVec3, spacing: f64) -> Surface {
    let cells = ((max - min) / spacing).ceil().max(DVec3::ONE).as_usizevec3();
    let points = cells + 1;
    let place = |x: usize, y: usize, z: usize| min + spacing * DVec3::new(x as f64, y as f64, z as f64);
    let at = |x: usize, y: usize, z: usize| (z * points.y + y) * points.x + x;
    let mut values = Vec::with_capacity(points.element_product());
    for (z, y, x) in grid(points) {
        values.push(field(place(x, y, z)));
    }
    let mut surface = Surface::default();
    for (z, y, x) in grid(cells) {
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
fn grid(size: USizeVec3) -> impl Iterator<Item = (usize, usize, usize)> {
    (0..size.z).flat_map(move |z| (0..size.y).flat_map(move |y| (0..size.x).map(move |x| (z, y, x))))
}

/// The piece of surface that cuts a right-handed tetrahedron of (place, value).
fn add_tetrahedron(surface: &mut Surface, field: &Field, corners: [(DVec3, f64); 4]) {
    let (mut order, mut inside) = ([0, 1, 2, 3], 0);
    // Inner corners first; whether the swaps were odd tells the handedness.
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
    let cut = |i: usize, j: usize| crossing(field, corners[order[i]], corners[order[j]]);
    match inside {
        1 => surface.triangle(cut(0, 1), cut(0, 2), cut(0, 3)),
        2 => surface.quad(cut(0, 2), cut(0, 3), cut(1, 3), cut(1, 2)),
        3 => surface.triangle(cut(0, 3), cut(1, 3), cut(2, 3)),
        _ => {}
    }
}

/// Where the surface crosses an edge; the same bits from both ends.
fn crossing(field: &Field, a: (DVec3, f64), b: (DVec3, f64)) -> DVec3 {
    let (inner, outer) = if a.1 < b.1 { (a.0, b.0) } else { (b.0, a.0) };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        *(if field(inner.lerp(outer, middle)) < 0.0 { &mut low } else { &mut high }) = middle;
    }
    inner.lerp(outer, (0.5 * (low + high)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE))
}
