//! The lattice of a distance grid while it is filled.

use glam::DVec3;
use solids::Mesh;

/// The lattice while the grid is filled.
pub(super) struct GridGeometry {
    /// The first node, mm.
    pub(super) origin: DVec3,
    /// Distance of neighbouring nodes, mm.
    pub(super) step: f64,
    /// Number of nodes along each axis.
    pub(super) dims: [usize; 3],
}

impl GridGeometry {
    /// A lattice of about `node_target` nodes that reaches `reach_mm` beyond a mesh, relative to `center`.
    pub(super) fn around(mesh: &Mesh, center: DVec3, reach_mm: f64, node_target: usize) -> Self {
        let bounds = mesh.bounds();
        let step_for = |pad: f64| ((bounds.size() + 2.0 * pad).element_product() / node_target as f64).cbrt().max(0.2);
        let step = step_for(reach_mm + step_for(reach_mm));
        let pad = reach_mm + 1.5 * step;
        let size = bounds.size() + 2.0 * pad;
        // Nodes are placed off round coordinates, where faces and edges often lie.
        let off = DVec3::new(0.0131, 0.0173, 0.0117) * step;
        let dims = (size / step).ceil().to_array().map(|n| n as usize + 2);
        Self { origin: bounds.min - center - pad + off, step, dims }
    }

    pub(super) fn node_position(&self, node: [usize; 3]) -> DVec3 {
        self.origin + DVec3::new(node[0] as f64, node[1] as f64, node[2] as f64) * self.step
    }

    /// Ranges of the nodes in a box, clamped to the lattice, inclusive.
    pub(super) fn node_ranges(&self, min: DVec3, max: DVec3) -> [(usize, usize); 3] {
        let (low, high) = (((min - self.origin) / self.step).to_array(), ((max - self.origin) / self.step).to_array());
        [0, 1, 2].map(|axis| {
            let last = self.dims[axis] - 1;
            let clamp = |v: f64| v.clamp(0.0, last as f64) as usize;
            (clamp(low[axis].ceil()), clamp(high[axis].floor()))
        })
    }
}
