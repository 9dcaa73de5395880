//! The closest surface point of each node of a lattice: tested near the triangles, handed on from node to node elsewhere.

use glam::{DVec3, Vec3, Vec4};
use solids::closest_point;

use super::grid_geometry::GridGeometry;

/// Nodes of a block.
const BLOCK_NODES: usize = 4;

/// Coordinates further away than any part, but with a finite square.
const FAR_AWAY_MM: f32 = 1e18;

/// The closest surface points known of nodes that follow each other along x.
#[derive(Clone, Copy)]
struct NodeBlock {
    x: [f32; BLOCK_NODES],
    y: [f32; BLOCK_NODES],
    z: [f32; BLOCK_NODES],
    /// Squared distances to them, mm2.
    squares: [f32; BLOCK_NODES],
}

/// The closest surface point known of each node.
pub(super) struct ClosestPoints<'a> {
    lattice: &'a GridGeometry,
    /// Rows of nodes along x. What the last block of a row holds beyond the lattice knows no surface.
    blocks: Vec<NodeBlock>,
    blocks_per_row: usize,
}

impl<'a> ClosestPoints<'a> {
    /// No surface is known.
    pub(super) fn new(lattice: &'a GridGeometry) -> Self {
        let [nx, ny, nz] = lattice.dims;
        let blocks_per_row = nx.div_ceil(BLOCK_NODES);
        let far = [FAR_AWAY_MM; BLOCK_NODES];
        let unknown = NodeBlock { x: far, y: far, z: far, squares: [f32::INFINITY; BLOCK_NODES] };
        Self { lattice, blocks: vec![unknown; blocks_per_row * ny * nz], blocks_per_row }
    }

    /// Takes a triangle into account for the nodes near it.
    pub(super) fn note_triangle(&mut self, triangle: &[DVec3; 3]) {
        let lattice = self.lattice;
        let band = 1.2 * lattice.step;
        let min = triangle[0].min(triangle[1]).min(triangle[2]) - band;
        let max = triangle[0].max(triangle[1]).max(triangle[2]) + band;
        let normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).normalize_or(DVec3::ZERO);
        let middle = (triangle[0] + triangle[1] + triangle[2]) / 3.0;
        let radius_mm = triangle.iter().map(|c| c.distance(middle)).fold(0.0, f64::max);
        let [xs, ys, zs] = lattice.node_ranges(min, max);
        // Along a row, the distance from the triangle's plane grows by this at each node.
        let rise = normal.x * lattice.step;
        let nodes_per_mm = if rise.abs() > 1e-9 * band { 1.0 / rise } else { 1e9 / band };
        for z in zs.0..=zs.1 {
            for y in ys.0..=ys.1 {
                let row = self.blocks_per_row * (z * lattice.dims[1] + y);
                let first = lattice.node_position([0, y, z]);
                let above = normal.dot(first - triangle[0]);
                // Only nodes that are no farther than the band from the plane.
                let (crossing, half) = (-above * nodes_per_mm, band * nodes_per_mm.abs());
                let low = (crossing - half).max(xs.0 as f64);
                let high = (crossing + half).min(xs.1 as f64);
                if low > high {
                    continue;
                }
                for x in (low + 0.999) as usize..=high as usize {
                    let (block, lane) = (&mut self.blocks[row + x / BLOCK_NODES], x % BLOCK_NODES);
                    let known_sq = block.squares[lane];
                    // A triangle is no closer than its plane. Many lie in one plane.
                    if (above + rise * x as f64).powi(2) >= (1.0 - 1e-6) * f64::from(known_sq) {
                        continue;
                    }
                    // Of many small triangles in a cell, most are farther away than one that was already tested.
                    let place = first.with_x(first.x + x as f64 * lattice.step);
                    if place.distance_squared(middle) > (radius_mm + f64::from(known_sq).sqrt()).powi(2) {
                        continue;
                    }
                    let closest = closest_point(place, triangle);
                    let distance_sq = closest.distance_squared(place) as f32;
                    if distance_sq < known_sq {
                        block.set_point(lane, closest.as_vec3(), distance_sq);
                    }
                }
            }
        }
    }

    /// One pass in which every node tries the closest points of the three nodes before it.
    pub(super) fn propagate(&mut self, backwards: [bool; 3]) {
        let [nx, ny, nz] = self.lattice.dims;
        let length = self.blocks_per_row;
        let (origin, step) = (self.lattice.origin.as_vec3(), self.lattice.step as f32);
        let turn = |at: usize, n: usize, back: bool| if back { n - 1 - at } else { at };
        for at_z in 0..nz {
            for at_y in 0..ny {
                let (y, z) = (turn(at_y, ny, backwards[1]), turn(at_z, nz, backwards[2]));
                let start = length * (z * ny + y);
                let place = NodePlaces { origin: origin + Vec3::new(0.0, y as f32, z as f32) * step, step, count: nx };
                for (at, stride, back) in [(at_y, length, backwards[1]), (at_z, length * ny, backwards[2])] {
                    if at > 0 {
                        let before = if back { start + stride } else { start - stride };
                        let (row, before) = two_rows(&mut self.blocks, start, before, length);
                        place.take_closer(row, before);
                    }
                }
                place.sweep_row(&mut self.blocks[start..start + length], backwards[0]);
            }
        }
    }

    /// Distances of all nodes to their closest points, mm.
    pub(super) fn distances(&self) -> Vec<f32> {
        let rows = self.blocks.chunks_exact(self.blocks_per_row);
        let squares = rows.flat_map(|row| row.iter().flat_map(|b| b.squares).take(self.lattice.dims[0]));
        squares.map(f32::sqrt).collect()
    }
}

impl NodeBlock {
    fn set_point(&mut self, lane: usize, point: Vec3, square: f32) {
        (self.x[lane], self.y[lane], self.z[lane]) = (point.x, point.y, point.z);
        self.squares[lane] = square;
    }
}

/// Where the nodes of a row are.
struct NodePlaces {
    /// The first node, mm.
    origin: Vec3,
    /// Distance of neighbouring nodes, mm.
    step: f32,
    /// Number of nodes.
    count: usize,
}

impl NodePlaces {
    /// Every node takes the closest point of the same node of another row if that is closer.
    fn take_closer(&self, row: &mut [NodeBlock], other: &[NodeBlock]) {
        for (number, (block, other)) in row.iter_mut().zip(other).enumerate() {
            let first = (number * BLOCK_NODES) as f32;
            let nodes = self.origin.x + (Vec4::new(0.0, 1.0, 2.0, 3.0) + first) * self.step;
            let [x, y, z] = [other.x, other.y, other.z].map(Vec4::from_array);
            let (off_x, off_y, off_z) = (x - nodes, y - self.origin.y, z - self.origin.z);
            let (squares, known) = (off_x * off_x + off_y * off_y + off_z * off_z, Vec4::from_array(block.squares));
            let is_closer = squares.cmplt(known);
            block.x = Vec4::select(is_closer, x, Vec4::from_array(block.x)).to_array();
            block.y = Vec4::select(is_closer, y, Vec4::from_array(block.y)).to_array();
            block.z = Vec4::select(is_closer, z, Vec4::from_array(block.z)).to_array();
            block.squares = squares.min(known).to_array();
        }
    }

    /// Every node of a row, in order, takes the closest point of the node before it if that is closer.
    fn sweep_row(&self, row: &mut [NodeBlock], backwards: bool) {
        let mut before = Vec3::splat(FAR_AWAY_MM);
        for at in 0..row.len() {
            let number = if backwards { row.len() - 1 - at } else { at };
            let block = &mut row[number];
            let lanes = BLOCK_NODES.min(self.count - number * BLOCK_NODES);
            let mut visit = |lane: usize| {
                let x = self.origin.x + (number * BLOCK_NODES + lane) as f32 * self.step;
                let square = before.distance_squared(self.origin.with_x(x));
                if square < block.squares[lane] {
                    block.set_point(lane, before, square);
                } else {
                    before = Vec3::new(block.x[lane], block.y[lane], block.z[lane]);
                }
            };
            if backwards {
                (0..lanes).rev().for_each(&mut visit);
            } else {
                (0..lanes).for_each(&mut visit);
            }
        }
    }
}

/// Two rows of the same length, the first of them to be changed.
fn two_rows(blocks: &mut [NodeBlock], start: usize, other: usize, length: usize) -> (&mut [NodeBlock], &[NodeBlock]) {
    let (low, high) = blocks.split_at_mut(start.max(other));
    match start < other {
        true => (&mut low[start..start + length], &high[..length]),
        false => (&mut high[..length], &low[other..other + length]),
    }
}
