//! Meshes made light enough for a browser: vertices that fall into the same cell of a grid become one.

use std::collections::HashMap;

use glam::{DVec3, IVec3};
use solids::Mesh;

/// A mesh for looking at: single precision, mm, in the frame of the mesh.
#[derive(Debug, Clone)]
pub(super) struct Light {
    pub(super) vertices: Vec<[f32; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// How often the grid is made coarser.
const TRIES: usize = 12;

/// A mesh of about `most` triangles or fewer.
pub(super) fn reduce(mesh: &Mesh, most: usize) -> Light {
    let all = || mesh.vertices().iter().map(|v| v.as_vec3().to_array()).collect();
    if mesh.triangles().len() <= most {
        return Light { vertices: all(), triangles: mesh.triangles().to_vec() };
    }
    let bounds = mesh.bounds();
    let longest_mm = bounds.size().max_element().max(1e-9);
    // A surface of n cells along its longest edge has at most some n * n of them.
    let mut cells = (most as f64).sqrt().max(4.0);
    let mut light = clustered(mesh, bounds.min, longest_mm / cells);
    for _ in 0..TRIES {
        if light.triangles.len() <= most {
            break;
        }
        cells *= ((most as f64 / light.triangles.len() as f64).sqrt() * 0.95).clamp(0.5, 0.95);
        light = clustered(mesh, bounds.min, longest_mm / cells);
    }
    light
}

/// Every vertex at the mean of those in its cell; triangles whose corners fall together are gone.
fn clustered(mesh: &Mesh, origin: DVec3, cell_mm: f64) -> Light {
    let mut cells: HashMap<IVec3, u32> = HashMap::new();
    let mut sums: Vec<(DVec3, f64)> = Vec::new();
    let owner: Vec<u32> = (mesh.vertices().iter())
        .map(|&vertex| {
            let cell = ((vertex - origin) / cell_mm).floor().as_ivec3();
            let at = *cells.entry(cell).or_insert_with(|| {
                sums.push((DVec3::ZERO, 0.0));
                sums.len() as u32 - 1
            });
            let sum = &mut sums[at as usize];
            *sum = (sum.0 + vertex, sum.1 + 1.0);
            at
        })
        .collect();
    let corners = mesh.triangles().iter().map(|t| t.map(|v| owner[v as usize]));
    let mut triangles: Vec<[u32; 3]> = corners.filter(|[a, b, c]| a != b && b != c && a != c).collect();
    // The same triangle over and over, as of a thin wall, is drawn once.
    triangles.sort_unstable();
    triangles.dedup();
    Light { vertices: sums.iter().map(|(sum, n)| (*sum / *n).as_vec3().to_array()).collect(), triangles }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reduced_part_keeps_its_bounds_and_has_no_more_triangles_than_asked() {
        for sample in sample_parts::all() {
            let light = reduce(&sample.mesh, 400);
            assert!(light.triangles.len() <= 400, "{}: {}", sample.name, light.triangles.len());
            assert!(light.triangles.len() > 20 || sample.mesh.triangles().len() <= 20, "{}", sample.name);
            let bounds = sample.mesh.bounds();
            let size = bounds.size().max_element();
            let low = light.vertices.iter().fold([f32::MAX; 3], |m, v| std::array::from_fn(|k| m[k].min(v[k])));
            let off = (DVec3::from_array(low.map(f64::from)) - bounds.min).abs().max_element();
            assert!(off < 0.2 * size, "{}: {off} of {size}", sample.name);
            assert!(light.triangles.iter().flatten().all(|&v| (v as usize) < light.vertices.len()));
        }
    }
}
