//! Reduces meshes for the browser by vertex clustering: vertices in the same grid cell become one.

use std::collections::HashMap;

use glam::{DVec3, IVec3};
use solids::Mesh;

/// A mesh for display: single precision, mm, in the frame of the mesh.
#[derive(Debug, Clone)]
pub(super) struct ReducedMesh {
    pub(super) vertices: Vec<[f32; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// How many times the grid is made coarser at most.
const MAX_ATTEMPTS: usize = 12;

/// Reduces a mesh to about `max_triangles` triangles or fewer.
pub(super) fn reduce_mesh(mesh: &Mesh, max_triangles: usize) -> ReducedMesh {
    let all = || mesh.vertices().iter().map(|v| v.as_vec3().to_array()).collect();
    if mesh.triangles().len() <= max_triangles {
        return ReducedMesh { vertices: all(), triangles: mesh.triangles().to_vec() };
    }
    let bounds = mesh.bounds();
    let longest_mm = bounds.size().max_element().max(1e-9);
    // A surface that spans n cells along its longest edge occupies about n * n cells at most.
    let mut cells = (max_triangles as f64).sqrt().max(4.0);
    let mut reduced = cluster_vertices(mesh, bounds.min, longest_mm / cells);
    for _ in 0..MAX_ATTEMPTS {
        if reduced.triangles.len() <= max_triangles {
            break;
        }
        cells *= ((max_triangles as f64 / reduced.triangles.len() as f64).sqrt() * 0.95).clamp(0.5, 0.95);
        reduced = cluster_vertices(mesh, bounds.min, longest_mm / cells);
    }
    reduced
}

/// Moves every vertex to the mean of the vertices in its cell, and removes triangles whose corners coincide.
fn cluster_vertices(mesh: &Mesh, origin: DVec3, cell_mm: f64) -> ReducedMesh {
    let mut cells: HashMap<IVec3, u32> = HashMap::new();
    let mut sums: Vec<(DVec3, f64)> = Vec::new();
    let cluster_of: Vec<u32> = (mesh.vertices().iter())
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
    let corners = mesh.triangles().iter().map(|t| t.map(|v| cluster_of[v as usize]));
    let mut triangles: Vec<[u32; 3]> = corners.filter(|[a, b, c]| a != b && b != c && a != c).collect();
    // Equal triangles, as a thin wall gives them, are drawn once.
    triangles.sort_unstable();
    triangles.dedup();
    ReducedMesh { vertices: sums.iter().map(|(sum, n)| (*sum / *n).as_vec3().to_array()).collect(), triangles }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reduced_part_keeps_its_bounds_and_has_no_more_triangles_than_asked() {
        for sample in sample_parts::all_samples() {
            let reduced = reduce_mesh(&sample.mesh, 400);
            assert!(reduced.triangles.len() <= 400, "{}: {}", sample.name, reduced.triangles.len());
            assert!(reduced.triangles.len() > 20 || sample.mesh.triangles().len() <= 20, "{}", sample.name);
            let bounds = sample.mesh.bounds();
            let size = bounds.size().max_element();
            let low = reduced.vertices.iter().fold([f32::MAX; 3], |m, v| std::array::from_fn(|k| m[k].min(v[k])));
            let off = (DVec3::from_array(low.map(f64::from)) - bounds.min).abs().max_element();
            assert!(off < 0.2 * size, "{}: {off} of {size}", sample.name);
            assert!(reduced.triangles.iter().flatten().all(|&v| (v as usize) < reduced.vertices.len()));
        }
    }
}
