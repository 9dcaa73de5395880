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
