//! Solids for the tests of this crate.

use std::{collections::BTreeSet, sync::Arc};

use glam::DVec3;
use solids::{Bounds, Mesh};

use crate::{
    NestingConfig, NestingInstance, PreparedMeshes, SearchComponents,
    prepare::{preparation::MeshPreparation, prepared_instance::PreparedInstance},
    problem::reserved,
    shapes::outline::OutlinedInstance,
};

/// A box from the origin.
pub(crate) fn block(size: DVec3) -> Arc<Mesh> {
    let bounds = Bounds { min: DVec3::ZERO, max: size };
    Arc::new(reserved::box_mesh(&bounds).expect("a box is a solid"))
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

/// A solid of cubes of `edge` mm at the given cells, which must not touch at edges or corners only.
pub(crate) fn cells(edge: f64, cells: impl IntoIterator<Item = [i32; 3]>) -> Arc<Mesh> {
    let cells: BTreeSet<[i32; 3]> = cells.into_iter().collect();
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for &cell in &cells {
        for axis in 0..3 {
            for side in [0, 1] {
                let mut neighbour = cell;
                neighbour[axis] += 2 * side - 1;
                if cells.contains(&neighbour) {
                    continue;
                }
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                let corner = |at_u: i32, at_v: i32| {
                    let mut at = cell;
                    (at[axis], at[u], at[v]) = (at[axis] + side, at[u] + at_u, at[v] + at_v);
                    DVec3::from_array(at.map(f64::from)) * edge
                };
                let first = vertices.len() as u32;
                vertices.extend([corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)]);
                let [a, b, c, d] = [0, 1, 2, 3].map(|k| first + k);
                triangles.extend(if side == 1 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
            }
        }
    }
    Arc::new(Mesh::new(vertices, triangles).expect("cells make a solid"))
}

/// All cells of a box of cells.
pub(crate) fn range(low: [i32; 3], high: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
    (low[0]..high[0]).flat_map(move |x| (low[1]..high[1]).flat_map(move |y| (low[2]..high[2]).map(move |z| [x, y, z])))
}

/// An instance with coarse collision proxies.
pub(crate) fn coarsely_prepared(instance: &NestingInstance) -> PreparedInstance {
    let prepared = PreparedMeshes::default();
    let preparation = MeshPreparation::new(&prepared, 1);
    let outlined = OutlinedInstance::new(instance, |meshes| preparation.prepare_outlines(meshes));
    PreparedInstance::new(Arc::new(outlined), BTreeSet::new(), &preparation, SearchComponents::default(), 2000, 100)
        .expect("there is no deadline")
}

/// A configuration of each method that is there; the published one with a small population and at most this number of layouts
/// (0 = any number).
pub(crate) fn each_method(max_layouts: u64) -> Vec<NestingConfig> {
    let own = NestingConfig::default();
    #[cfg(feature = "paper")]
    {
        let paper = crate::PaperConfig { population: 20, iterations: 20, max_layouts, ..crate::PaperConfig::default() };
        vec![own.clone(), NestingConfig { method: crate::NestingMethod::Paper, paper, ..own }]
    }
    #[cfg(not(feature = "paper"))]
    {
        let _ = max_layouts;
        vec![own]
    }
}
