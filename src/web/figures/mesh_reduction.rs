//! Reduces meshes for the browser: edges are collapsed where that changes the surface least (Garland and Heckbert's quadric
//! errors, as the library meshoptimizer has them), so that holes stay round and thin walls stay walls.

use meshopt::SimplifyOptions;
use solids::Mesh;

/// A mesh for display: single precision, mm, in the frame of the mesh.
#[derive(Debug, Clone)]
pub(crate) struct ReducedMesh {
    pub(crate) vertices: Vec<[f32; 3]>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Whether it may be seen that it has fewer triangles than its file.
    pub(crate) is_simplified: bool,
}

/// Largest error of the surface of any mesh, as a share of its longest side: no pixel of a screen.
const LEAST_ERROR: f32 = 0.0005;
/// Largest error of a mesh with too many triangles: less than anybody sees.
const UNSEEN_ERROR: f32 = 0.005;
/// Any error.
const ANY_ERROR: f32 = 1.0;

/// Reduces a mesh to about `max_triangles` triangles or fewer: a mesh that would look broken, such as a lattice, keeps up to
/// twice as many. Triangles and vertices stand in an order in which neighbours follow each other, which compresses well.
pub(crate) fn reduce_mesh(mesh: &Mesh, max_triangles: usize) -> ReducedMesh {
    let vertices: Vec<[f32; 3]> = mesh.vertices().iter().map(|v| v.as_vec3().to_array()).collect();
    let mut corners = mesh.triangles().as_flattened().to_vec();
    let mut reduce_to = |max: usize, error: f32, options: SimplifyOptions| {
        let most = max.saturating_mul(3);
        let is_more = corners.len() > most;
        if is_more {
            corners = meshopt::simplify_decoder(&corners, &vertices, most, error, options, None);
        }
        is_more
    };
    // Bodies that nobody sees are left out.
    reduce_to(0, LEAST_ERROR, SimplifyOptions::Prune);
    let is_simplified = reduce_to(max_triangles, UNSEEN_ERROR, SimplifyOptions::Prune);
    let most = max_triangles.saturating_mul(2);
    reduce_to(most, ANY_ERROR, SimplifyOptions::None);
    // Many small bodies cannot become few triangles each by themselves.
    if corners.len() > 3 * most {
        let sloppy = meshopt::simplify_sloppy_decoder(&corners, &vertices, 3 * most, ANY_ERROR, None);
        if sloppy.is_empty() { corners.truncate(3 * most) } else { corners = sloppy }
    }
    let mut corners = meshopt::optimize_vertex_cache(&corners, vertices.len());
    let vertices = meshopt::optimize_vertex_fetch(&mut corners, &vertices);
    ReducedMesh { vertices, triangles: corners.as_chunks().0.to_vec(), is_simplified }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    /// Volume between the surface and the origin, mm3.
    fn volume_mm3(vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> f64 {
        let corner = |v: u32| DVec3::from_array(vertices[v as usize].map(f64::from));
        triangles.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c))) / 6.0).sum()
    }

    #[test]
    fn a_reduced_part_keeps_its_bounds_and_its_volume_and_has_few_triangles() {
        for sample in sample_parts::all_samples() {
            let vertices = sample.mesh.vertices().iter().map(|v| v.as_vec3().to_array()).collect();
            let whole = ReducedMesh { vertices, triangles: sample.mesh.triangles().to_vec(), is_simplified: false };
            let reduced = reduce_mesh(&sample.mesh, 1000);
            assert!(reduced.triangles.len() <= 2000, "{}: {}", sample.name, reduced.triangles.len());
            assert!(reduced.triangles.iter().flatten().all(|&v| (v as usize) < reduced.vertices.len()));
            let extents = |mesh: &ReducedMesh| {
                let fold = |of: fn(f32, f32) -> f32, start| {
                    mesh.vertices.iter().fold([start; 3], |all: [f32; 3], v| std::array::from_fn(|k| of(all[k], v[k])))
                };
                (fold(f32::min, f32::MAX), fold(f32::max, f32::MIN))
            };
            let size = sample.mesh.bounds().size().max_element() as f32;
            let ((low, high), (least, most)) = (extents(&whole), extents(&reduced));
            for k in 0..3 {
                assert!((low[k] - least[k]).abs() < 0.02 * size, "{}: bounds {low:?} {least:?}", sample.name);
                assert!((high[k] - most[k]).abs() < 0.02 * size, "{}: bounds {high:?} {most:?}", sample.name);
            }
            // Holes that became square, or walls that became wedges, would have another volume.
            let share =
                volume_mm3(&reduced.vertices, &reduced.triangles) / volume_mm3(&whole.vertices, &whole.triangles);
            assert!((share - 1.0).abs() < 0.1, "{}: {share} of its volume", sample.name);
        }
    }

    #[test]
    fn a_part_of_many_bodies_stays_in_the_view_with_few_triangles() {
        let cube = sample_parts::cuboid(DVec3::splat(2.0));
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for at in 0..3000 {
            let (first, place) = (vertices.len() as u32, DVec3::new(f64::from(at % 60), f64::from(at / 60), 0.0) * 3.0);
            vertices.extend(cube.vertices().iter().map(|&vertex| vertex + place));
            triangles.extend(cube.triangles().iter().map(|t| t.map(|corner| first + corner)));
        }
        let many = Mesh::new(vertices, triangles).unwrap();
        for max in [150, 10_000] {
            let reduced = reduce_mesh(&many, max);
            assert!((1..=2 * max).contains(&reduced.triangles.len()), "{max}: {}", reduced.triangles.len());
            assert!(reduced.is_simplified && reduced.vertices.len() < 1 << 16);
        }
    }
}
