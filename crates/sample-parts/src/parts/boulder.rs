//! A boulder: a smooth body with bumps, with as many triangles as wanted, like the scan of a found object.

use glam::{DVec3, IVec3};
use solids::Mesh;

/// The number of triangles of a boulder with `steps` steps along the edge of each side.
const TRIANGLES_PER_STEP: u32 = 12;

/// A bumpy ball about `diameter_mm` across, of 12 `steps`² triangles in one shell. The coordinates are those of 32-bit
/// numbers, so that an STL file holds the same surface.
pub fn boulder(diameter_mm: f64, steps: u32) -> Mesh {
    let n = steps.max(1) as i32;
    let place = |grid: IVec3| {
        let way = (grid.as_dvec3() / f64::from(n)).normalize();
        (way * (0.5 * diameter_mm * bumps(way))).as_vec3().as_dvec3()
    };
    let mut corners = Vec::with_capacity((3 * TRIANGLES_PER_STEP * steps * steps) as usize);
    for (axis, side) in (0..3).flat_map(|axis| [-1, 1].map(|side| (axis, side))) {
        // The grid of a side of the cube from -n to n, seen from outside with u to the right and v upwards.
        let at = |u: i32, v: i32| {
            let mut grid = IVec3::ZERO;
            grid[axis] = side * n;
            grid[(axis + 1) % 3] = side * (2 * u - n);
            grid[(axis + 2) % 3] = 2 * v - n;
            place(grid)
        };
        for (u, v) in (0..n).flat_map(|u| (0..n).map(move |v| (u, v))) {
            let [a, b, c, d] = [at(u, v), at(u + 1, v), at(u + 1, v + 1), at(u, v + 1)];
            corners.extend([a, b, c, a, c, d]);
        }
    }
    let triangles = (0..corners.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    Mesh::new(corners, triangles).expect("a boulder encloses a volume")
}

/// The radius in a direction, as a share of the mean: waves of several lengths.
fn bumps(way: DVec3) -> f64 {
    let wave = |count: f64, share: f64| {
        let at = way * count;
        share * ((at.x + 0.7 * at.y).sin() * (at.y - 0.4 * at.z).sin() + (at.z + 0.9 * at.x).cos())
    };
    0.78 + wave(2.3, 0.08) + wave(7.0, 0.02) + wave(23.0, 0.004) + wave(90.0, 0.0006)
}
