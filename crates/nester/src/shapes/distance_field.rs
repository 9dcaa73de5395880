//! A signed distance grid: the distance of a point to a solid and the direction outwards, in nanoseconds. It guides the
//! search only; validity is decided by the exact box tree.

mod block_lookup;
mod closest_points;
mod grid_geometry;

use glam::{DVec3, Vec3};
use solids::Mesh;

use self::{closest_points::ClosestPoints, grid_geometry::GridGeometry};
use super::{
    byte_codec::{ByteReader, ByteWriter},
    point_block::EXACT_INTEGERS,
};

/// Triangles between two checks of the clock; each triangle may fill the whole grid.
const TRIANGLES_PER_CHECK: usize = 64;
/// Of meshes with more triangles, not every one is tested.
const MAX_TESTED_TRIANGLES: usize = 200_000;

/// Signed distance to a solid's surface, negative inside and in sealed cavities, in the solid's frame relative to
/// `center`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct DistanceField {
    origin: Vec3,
    step: f32,
    inverse_step: f32,
    dims: [usize; 3],
    scale: f32,
    nodes: Vec<i16>,
    /// No point outside the grid has a distance below this, mm.
    edge_distance: f32,
}

impl DistanceField {
    /// Fills a grid of about `node_target` nodes that reaches `reach_mm` beyond the mesh; `None` when the time runs out
    /// first.
    pub(crate) fn new(
        mesh: &Mesh,
        center: DVec3,
        reach_mm: f64,
        node_target: usize,
        is_over: &dyn Fn() -> bool,
    ) -> Option<Self> {
        let lattice = GridGeometry::around(mesh, center, reach_mm, node_target);
        let triangles = || (0..mesh.triangles().len()).map(|t| mesh.corners(t).map(|c| c - center));
        let distances = node_distances(&lattice, triangles(), is_over)?;
        let inside = super::solid_nodes::solid_nodes(lattice.dims, lattice.origin, lattice.step, triangles());
        let greatest = distances.iter().fold(0.0_f32, |most, &d| most.max(d));
        let scale = greatest.max(1e-6) / 32_000.0;
        let node = |(d, inside): (&f32, &bool)| (if *inside { -d } else { *d } / scale).round() as i16;
        let nodes = distances.iter().zip(&inside).map(node).collect();
        Some(Self::from_nodes(lattice.origin.as_vec3(), lattice.step as f32, scale, lattice.dims, nodes))
    }

    fn from_nodes(origin: Vec3, step: f32, scale: f32, dims: [usize; 3], nodes: Vec<i16>) -> Self {
        // A point outside is looked up where it is nearest to it: between the first two or the last two nodes.
        let is_edge = |at: usize, axis: usize| at == 0 || at + 2 >= dims[axis];
        let mut least = i16::MAX;
        for (row, line) in nodes.chunks_exact(dims[0]).enumerate() {
            let at_edge = match is_edge(row % dims[1], 1) || is_edge(row / dims[1], 2) {
                true => line.iter().min(),
                false => [0, dims[0] - 2, dims[0] - 1].map(|x| &line[x]).into_iter().min(),
            };
            least = least.min(at_edge.copied().unwrap_or(least));
        }
        // One less, for the rounding of a mean.
        let edge_distance = (f32::from(least) - 1.0) * scale;
        Self { origin, step, inverse_step: 1.0 / step, dims, scale, nodes, edge_distance }
    }

    /// Writes the grid as bytes.
    pub(super) fn write_to(&self, to: &mut ByteWriter) {
        to.write_f32s(&self.origin.to_array());
        to.write_f32s(&[self.step, self.scale]);
        self.dims.iter().for_each(|&n| to.write_u32(n as u32));
        self.nodes.iter().for_each(|node| to.0.extend(node.to_le_bytes()));
    }

    /// Reads the grid from bytes.
    pub(super) fn read_from(from: &mut ByteReader<'_>) -> Option<Self> {
        let origin = Vec3::from_array(from.read_f32s()?);
        let [step, scale] = from.read_f32s()?;
        let dims = [from.read_u32()? as usize, from.read_u32()? as usize, from.read_u32()? as usize];
        let count = dims[0].checked_mul(dims[1])?.checked_mul(dims[2])?;
        let nodes: Vec<i16> = (from.read_bytes(count.checked_mul(2)?)?.chunks_exact(2))
            .map(|pair| i16::from_le_bytes([pair[0], pair[1]]))
            .collect();
        let is_sound = step > 0.0 && scale > 0.0 && dims.iter().all(|&n| n >= 2) && count < EXACT_INTEGERS as usize;
        is_sound.then(|| Self::from_nodes(origin, step, scale, dims, nodes))
    }

    /// Signed distance at a point, mm. Outside the grid, the distance to the grid is added.
    #[inline(always)]
    pub(crate) fn distance(&self, point: Vec3) -> f32 {
        let (at, part, beyond) = self.locate_cell(point);
        let [c000, c100, c010, c110, c001, c101, c011, c111] = self.cell_corners(at);
        let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
        let low = mix(mix(c000, c100, part.x), mix(c010, c110, part.x), part.y);
        let high = mix(mix(c001, c101, part.x), mix(c011, c111, part.x), part.y);
        mix(low, high, part.z) * self.scale + beyond
    }

    /// The unit direction in which the distance grows.
    #[inline(always)]
    pub(crate) fn gradient(&self, point: Vec3) -> Vec3 {
        let (at, part, _) = self.locate_cell(point);
        let [c000, c100, c010, c110, c001, c101, c011, c111] = self.cell_corners(at);
        let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
        let (x00, x10) = (mix(c000, c100, part.x), mix(c010, c110, part.x));
        let (x01, x11) = (mix(c001, c101, part.x), mix(c011, c111, part.x));
        let (low, high) = (mix(x00, x10, part.y), mix(x01, x11, part.y));
        let along_x = mix(mix(c100 - c000, c110 - c010, part.y), mix(c101 - c001, c111 - c011, part.y), part.z);
        let along_y = mix(x10 - x00, x11 - x01, part.z);
        Vec3::new(along_x, along_y, high - low).normalize_or(Vec3::Z)
    }

    /// First node of the cell that contains a point, the point's position in the cell, and its distance to the grid.
    #[inline(always)]
    fn locate_cell(&self, point: Vec3) -> (usize, Vec3, f32) {
        let raw = (point - self.origin) * self.inverse_step;
        let most = Vec3::new(self.dims[0] as f32, self.dims[1] as f32, self.dims[2] as f32) - 1.001;
        let inner = raw.clamp(Vec3::ZERO, most);
        let beyond = if inner == raw { 0.0 } else { (raw - inner).length() * self.step };
        let (x, y, z) = (inner.x as usize, inner.y as usize, inner.z as usize);
        let part = inner - Vec3::new(x as f32, y as f32, z as f32);
        ((z * self.dims[1] + y) * self.dims[0] + x, part, beyond)
    }

    #[inline(always)]
    fn cell_corners(&self, at: usize) -> [f32; 8] {
        let (row, layer) = (self.dims[0], self.dims[0] * self.dims[1]);
        let n = &self.nodes[at..at + layer + row + 2];
        [n[0], n[1], n[row], n[row + 1], n[layer], n[layer + 1], n[layer + row], n[layer + row + 1]].map(f32::from)
    }
}

/// Distance of every node to the surface, mm: exact near the surface, propagated outwards by closest points. Of a mesh with
/// very many triangles, one of those that are small beside the lattice stands for its neighbours.
fn node_distances(
    lattice: &GridGeometry,
    triangles: impl ExactSizeIterator<Item = [DVec3; 3]>,
    is_over: &dyn Fn() -> bool,
) -> Option<Vec<f32>> {
    let mut closest = ClosestPoints::new(lattice);
    let mut thinned = (triangles.len() > MAX_TESTED_TRIANGLES).then(|| ThinnedTriangles::new(lattice));
    for (at, triangle) in triangles.enumerate() {
        if at % TRIANGLES_PER_CHECK == 0 && is_over() {
            return None;
        }
        if thinned.as_mut().is_none_or(|thinned| thinned.takes_triangle(&triangle)) {
            closest.note_triangle(&triangle);
        }
    }
    // Opposite directions follow each other.
    for backwards in [[false, false, false], [true, false, true], [false, false, true], [true, false, false]] {
        closest.propagate(backwards);
        closest.propagate(backwards.map(|back| !back));
    }
    Some(closest.distances())
}

/// Of many triangles that are small beside the lattice, the first in each small cell: the others are no farther from it than
/// the cell is wide.
struct ThinnedTriangles {
    origin: DVec3,
    cells_per_mm: f64,
    dims: [usize; 3],
    /// A bit for each cell.
    taken: Vec<u64>,
}

impl ThinnedTriangles {
    /// Cells along the step of the lattice.
    const CELLS_PER_STEP: usize = 5;

    fn new(lattice: &GridGeometry) -> Self {
        let dims = lattice.dims.map(|n| n * Self::CELLS_PER_STEP);
        let cells_per_mm = Self::CELLS_PER_STEP as f64 / lattice.step;
        let cells: usize = dims.iter().product();
        Self { origin: lattice.origin, cells_per_mm, dims, taken: vec![0; cells.div_ceil(64)] }
    }

    /// Whether a triangle is larger than a cell, or the first one in its cell.
    fn takes_triangle(&mut self, &[a, b, c]: &[DVec3; 3]) -> bool {
        let size = (a.max(b).max(c) - a.min(b).min(c)).max_element();
        if size * self.cells_per_mm > 1.0 {
            return true;
        }
        let at = ((a - self.origin) * self.cells_per_mm).max(DVec3::ZERO).as_usizevec3().to_array();
        let [x, y, z] = [0, 1, 2].map(|axis| at[axis].min(self.dims[axis] - 1));
        let cell = (z * self.dims[1] + y) * self.dims[0] + x;
        let (word, bit) = (&mut self.taken[cell / 64], 1 << (cell % 64));
        let is_first = *word & bit == 0;
        *word |= bit;
        is_first
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use sample_parts::fixtures::star;
    use solids::closest_point;

    use super::*;
    use crate::tests::testing::{block, hollow};

    #[test]
    fn a_box_knows_its_distances_inside_and_outside() {
        let size = DVec3::new(20.0, 10.0, 30.0);
        let field = DistanceField::new(&block(size), size * 0.5, 4.0, 60_000, &|| false).unwrap();
        for (point, wanted) in [
            (Vec3::ZERO, -5.0),
            (Vec3::new(12.0, 0.0, 0.0), 2.0),
            (Vec3::new(0.0, 4.0, 10.0), -1.0),
            (Vec3::new(0.0, 0.0, 18.0), 3.0),
        ] {
            let found = field.distance(point);
            assert!((found - wanted).abs() < 0.1, "{point} {found} {wanted}");
        }
        let gradient = field.gradient(Vec3::new(0.0, 4.0, 10.0));
        assert!(gradient.dot(Vec3::Y) > 0.99, "{gradient}");
        assert!(field.distance(Vec3::new(100.0, 0.0, 0.0)) > 60.0);
    }

    #[test]
    fn a_sealed_cavity_is_solid() {
        let field = DistanceField::new(&hollow(30.0, 1.0), DVec3::splat(15.0), 2.0, 20_000, &|| false).unwrap();
        assert!(field.distance(Vec3::ZERO) < 0.0);
        assert!(field.distance(Vec3::new(16.5, 0.0, 0.0)) > 0.0);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        #[test]
        fn every_node_gets_about_its_distance_and_never_less(
            size in proptest::array::uniform3(3.0..12.0f64), seed in 0.0..6.0f64, nx in 15..31usize, detail in 1..4u32,
        ) {
            let shape = DVec3::from_array(size);
            let mesh = star(detail, move |d| (shape * d).length() * (1.0 + 0.3 * (4.0 * d.y + seed).sin()));
            let bounds = mesh.bounds();
            let step = bounds.size().max_element() * 1.8 / nx as f64;
            let lattice = GridGeometry { origin: bounds.min - 0.2 * bounds.size(), step, dims: [nx, nx - 3, nx + 2] };
            let corners: Vec<[DVec3; 3]> = (0..mesh.triangles().len()).map(|t| mesh.corners(t)).collect();
            let found = node_distances(&lattice, corners.iter().copied(), &|| false).expect("is never over");
            prop_assert_eq!(found.len(), nx * (nx - 3) * (nx + 2));
            let mut off = 0.0;
            for (number, &distance) in found.iter().enumerate() {
                let node = [number % nx, number / nx % (nx - 3), number / nx / (nx - 3)];
                let place = lattice.node_position(node);
                let exact = corners.iter().map(|t| closest_point(place, t).distance(place)).fold(f64::INFINITY, f64::min);
                let more = (f64::from(distance) - exact) / step;
                prop_assert!(more > -1e-4, "{node:?}: {distance} instead of {exact}");
                prop_assert!(more < 1e-4 || exact > 1.19 * step, "{node:?}: {distance} instead of {exact}, although it is near");
                off += more;
            }
            prop_assert!(off / (found.len() as f64) < 0.06, "{off}");
        }
    }
}
