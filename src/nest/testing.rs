//! Solids for this room's tests.

use std::sync::Arc;

use glam::DVec3;

use crate::geometry::Mesh;

/// A box from the origin.
pub(crate) fn block(size: DVec3) -> Arc<Mesh> {
    let corner = |n: usize| size * DVec3::new((n & 1) as f64, (n >> 1 & 1) as f64, (n >> 2 & 1) as f64);
    let triangles = vec![
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    Arc::new(Mesh::new((0..8).map(corner).collect(), triangles).expect("a box is a solid"))
}

/// A box of edge `size` with a sealed box-shaped cavity whose walls are `wall` thick.
pub(crate) fn hollow(size: f64, wall: f64) -> Arc<Mesh> {
    let (outer, inner) = (block(DVec3::splat(size)), block(DVec3::splat(size - 2.0 * wall)));
    let mut vertices = outer.vertices().to_vec();
    let mut triangles = outer.triangles().to_vec();
    let first = vertices.len() as u32;
    vertices.extend(inner.vertices().iter().map(|&v| v + wall));
    triangles.extend(inner.triangles().iter().map(|&[a, b, c]| [a + first, c + first, b + first]));
    Arc::new(Mesh::new(vertices, triangles).expect("a hollow box is a solid"))
}

/// A tetrahedron with the given corners.
pub(crate) fn tetrahedron(corners: [DVec3; 4]) -> Arc<Mesh> {
    let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    Arc::new(Mesh::new(corners.to_vec(), triangles).expect("a tetrahedron is a solid"))
}
