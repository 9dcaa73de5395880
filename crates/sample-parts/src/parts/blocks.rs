//! Parts made of bricks: the solid cells of an uneven grid.

use glam::DVec2;
use solids::Mesh;

use crate::making::{
    layers::extrude_layers,
    outline::{PlanarOutline, rectangle},
};

/// The solid cells of the grid with the given lines, mm.
fn solid_cells(xs: &[f64], ys: &[f64], zs: &[f64], solid: impl Fn(usize, usize, usize) -> bool) -> Mesh {
    let columns = xs.len() - 1;
    let cell = |x: usize, y: usize| rectangle(DVec2::new(xs[x], ys[y]), DVec2::new(xs[x + 1], ys[y + 1]));
    let regions: Vec<PlanarOutline> = (0..ys.len() - 1)
        .flat_map(|y| (0..columns).map(move |x| (x, y)))
        .map(|(x, y)| PlanarOutline::new(cell(x, y)))
        .collect();
    extrude_layers(&regions, zs, |region, slab| solid(region % columns, region / columns, slab), |_, _| true)
        .into_mesh()
}

/// Coordinates of alternating walls and gaps: cells 0, 2, 4 .. are walls.
fn walls_and_gaps(gaps: usize, wall: f64, pitch: f64) -> Vec<f64> {
    (0..=gaps).flat_map(|i| [pitch * i as f64, pitch * i as f64 + wall]).collect()
}

/// A cubic lattice of square struts, mm: `cells` per axis.
pub fn lattice_block(cells: [usize; 3], pitch_mm: f64, strut_mm: f64) -> Mesh {
    let [xs, ys, zs] = cells.map(|n| walls_and_gaps(n, strut_mm, pitch_mm));
    solid_cells(&xs, &ys, &zs, |x, y, z| [x, y, z].iter().filter(|&i| i % 2 == 0).count() >= 2)
}

/// An open tray with compartments, mm.
pub fn tray(compartments: [usize; 2], pitch_mm: f64, height_mm: f64, wall_mm: f64) -> Mesh {
    let [xs, ys] = compartments.map(|n| walls_and_gaps(n, wall_mm, pitch_mm));
    let zs = [0.0, wall_mm, 0.4 * height_mm, 0.7 * height_mm, height_mm];
    // Inner walls stop lower than the rim.
    let rim = |i: usize, n: usize| i == 0 || i == 2 * n;
    let [nx, ny] = compartments;
    solid_cells(&xs, &ys, &zs, |x, y, z| match z {
        0 => true,
        3 => rim(x, nx) || rim(y, ny),
        _ => x % 2 == 0 || y % 2 == 0,
    })
}
