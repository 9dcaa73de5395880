//! A binary tree of boxes over triangles. All boxes are aligned with one frame.

use glam::{DVec3, Vec3};

use super::{Bounds, Mesh, Pose, triangle::Triangle};

/// Greatest number of triangles in a leaf: with fewer, testing boxes costs more than it saves.
pub(super) const MAX_LEAF_TRIANGLES: usize = 4;
/// Number of split positions tried along an axis.
const BINS: usize = 16;
/// With more triangles, a sample of them is used to choose a split.
const SPLIT_SAMPLE: usize = 2048;
/// Below this depth, nodes are halved by count, so that a traversal is never deeper than about twice 40.
const MAX_UNEVEN_DEPTH: usize = 24;

/// A box and its contents.
#[derive(Debug, Clone, Copy)]
pub(super) struct BoxTreeNode {
    /// Middle of the box, mm.
    pub center: DVec3,
    /// Half the edge lengths, mm.
    pub half: DVec3,
    /// First triangle of a leaf, or the first of the two children, which are stored next to each other.
    pub first: u32,
    /// Triangles of a leaf; 0 for an inner node.
    pub count: u32,
}

impl BoxTreeNode {
    /// The triangles of a leaf.
    pub fn triangle_range(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }

    /// Whether the node has triangles instead of children.
    pub fn is_leaf(&self) -> bool {
        self.count > 0
    }
}

/// The tree, with the triangles in the order of its leaves and in its own frame.
#[derive(Debug, Clone)]
pub(super) struct TriangleBoxTree {
    pub nodes: Vec<BoxTreeNode>,
    pub triangles: Vec<Triangle>,
    /// Bounds of the triangle normals of each node.
    pub normal_bounds: Vec<NormalBounds>,
    /// The connected shell of the surface to which each triangle belongs.
    pub shell_of: Vec<u32>,
    /// A corner of each connected shell.
    shells: Vec<DVec3>,
}

impl TriangleBoxTree {
    /// Builds the tree over a mesh; `to_box` transforms the mesh to the tree's frame.
    pub fn new(mesh: &Mesh, to_box: &Pose) -> Self {
        let places: Vec<DVec3> = mesh.vertices().iter().map(|&v| to_box.transform_point(v)).collect();
        let turn = to_box.rotation_matrix();
        let (shell_of_vertex, shells) = find_shells(mesh);
        let mut pieces: Vec<TriangleEntry> = (mesh.triangles().iter().enumerate())
            .map(|(index, corners)| TriangleEntry::new(index as u32, corners.map(|v| places[v as usize])))
            .collect();
        let mut nodes = vec![BoxTreeNode { center: DVec3::ZERO, half: DVec3::ZERO, first: 0, count: 0 }];
        build_node(&mut nodes, &mut pieces, 0, 0, 0);
        let triangle = |piece: &TriangleEntry| {
            let index = piece.index as usize;
            // The normal comes from the original corners: rotating them first would round a sliver's normal away.
            let normal = turn * Triangle::new(mesh.corners(index)).normal;
            Triangle { corners: mesh.triangles()[index].map(|v| places[v as usize]), normal }
        };
        let shell = |piece: &TriangleEntry| shell_of_vertex[mesh.triangles()[piece.index as usize][0] as usize];
        let triangles: Vec<Triangle> = pieces.iter().map(triangle).collect();
        Self {
            normal_bounds: normal_bounds(&nodes, &triangles),
            triangles,
            shell_of: pieces.iter().map(shell).collect(),
            shells: shells.into_iter().map(|v| places[v]).collect(),
            nodes,
        }
    }

    /// A corner of each connected shell of the surface.
    pub fn shells(&self) -> &[DVec3] {
        &self.shells
    }

    /// Whether the root box contains a point.
    pub fn root_contains(&self, point: DVec3) -> bool {
        let root = &self.nodes[0];
        (point - root.center).abs().cmple(root.half).all()
    }

    /// The greatest dot product of a corner with `direction`, by branch and bound. Exact up to rounding: boxes that
    /// could improve the result only by rounding are skipped, since otherwise all corners of a flat face would be
    /// tested.
    pub fn support_value(&self, direction: DVec3) -> f64 {
        let mut best = f64::NEG_INFINITY;
        let slack = 1e-13 * self.nodes[0].half.dot(direction.abs());
        self.support_in_node(0, direction, slack, &mut best);
        best
    }

    fn support_in_node(&self, node: usize, direction: DVec3, slack: f64, best: &mut f64) {
        let node = &self.nodes[node];
        if node.is_leaf() {
            for triangle in &self.triangles[node.triangle_range()] {
                *best = triangle.corners.iter().fold(*best, |best, c| best.max(c.dot(direction)));
            }
            return;
        }
        let children = [node.first as usize, node.first as usize + 1];
        let bounds = children.map(|c| self.nodes[c].center.dot(direction) + self.nodes[c].half.dot(direction.abs()));
        let order = if bounds[0] >= bounds[1] { [0, 1] } else { [1, 0] };
        for i in order {
            if bounds[i] > *best + slack {
                self.support_in_node(children[i], direction, slack, best);
            }
        }
    }
}

/// Bounds of unit normals; single precision, grown by more than its rounding.
#[derive(Debug, Clone, Copy)]
pub(super) struct NormalBounds {
    middle: Vec3,
    half: Vec3,
}

impl NormalBounds {
    /// The least and the greatest dot product of a normal with `direction`, whose absolute values are `spread`.
    #[inline]
    pub fn dot_range(&self, direction: Vec3, spread: Vec3) -> (f32, f32) {
        let (middle, half) = (self.middle.dot(direction), self.half.dot(spread));
        (middle - half, middle + half)
    }
}

/// The bounds of the normals below every node; children are stored after their parents.
fn normal_bounds(nodes: &[BoxTreeNode], triangles: &[Triangle]) -> Vec<NormalBounds> {
    const GROWN: f32 = 1e-6;
    let mut limits = vec![(Vec3::INFINITY, Vec3::NEG_INFINITY); nodes.len()];
    for (at, node) in nodes.iter().enumerate().rev() {
        let join = |a: (Vec3, Vec3), b: (Vec3, Vec3)| (a.0.min(b.0), a.1.max(b.1));
        limits[at] = if node.is_leaf() {
            let own = |triangle: &Triangle| match triangle.normal {
                // A triangle without a normal may face any direction.
                DVec3::ZERO => (Vec3::NEG_ONE, Vec3::ONE),
                normal => (normal.as_vec3(), normal.as_vec3()),
            };
            triangles[node.triangle_range()].iter().map(own).fold(limits[at], join)
        } else {
            join(limits[node.first as usize], limits[node.first as usize + 1])
        };
    }
    let facing = |(min, max): (Vec3, Vec3)| NormalBounds { middle: (min + max) * 0.5, half: (max - min) * 0.5 + GROWN };
    limits.into_iter().map(facing).collect()
}

/// A triangle while the tree is being built.
struct TriangleEntry {
    index: u32,
    bounds: Bounds,
    center: DVec3,
}

impl TriangleEntry {
    fn new(index: u32, corners: [DVec3; 3]) -> Self {
        let bounds = Bounds::from_points(corners);
        Self { index, center: bounds.center(), bounds }
    }
}

fn join_bounds(one: Bounds, two: &Bounds) -> Bounds {
    Bounds { min: one.min.min(two.min), max: one.max.max(two.max) }
}

/// Builds node `at` from `pieces`; `first` is the index of the first of them in the tree's order.
fn build_node(nodes: &mut Vec<BoxTreeNode>, pieces: &mut [TriangleEntry], at: usize, first: usize, depth: usize) {
    let bounds = pieces.iter().fold(Bounds::EMPTY, |all, p| join_bounds(all, &p.bounds));
    let center = bounds.center();
    // A rounded center must not leave a corner outside.
    let half = (bounds.max - center).max(center - bounds.min);
    if pieces.len() <= MAX_LEAF_TRIANGLES {
        nodes[at] = BoxTreeNode { center, half, first: first as u32, count: pieces.len() as u32 };
        return;
    }
    let middle = split_entries(pieces, depth);
    let child = nodes.len();
    nodes[at] = BoxTreeNode { center, half, first: child as u32, count: 0 };
    nodes.extend([nodes[at]; 2]);
    let (left, right) = pieces.split_at_mut(middle);
    build_node(nodes, left, child, first, depth + 1);
    build_node(nodes, right, child + 1, first + middle, depth + 1);
}

/// Orders the pieces into two groups and returns the size of the first.
fn split_entries(pieces: &mut [TriangleEntry], depth: usize) -> usize {
    let centers = Bounds::from_points(pieces.iter().map(|p| p.center));
    let best = if depth < MAX_UNEVEN_DEPTH { cheapest_plane(pieces, &centers) } else { None };
    if let Some((axis, plane)) = best {
        let mut middle = 0;
        for i in 0..pieces.len() {
            if bin_index(pieces[i].center[axis], &centers, axis) < plane {
                pieces.swap(i, middle);
                middle += 1;
            }
        }
        return middle;
    }
    let axis = centers.size().max_position();
    let middle = pieces.len() / 2;
    pieces.select_nth_unstable_by(middle, |a, b| a.center[axis].total_cmp(&b.center[axis]));
    middle
}

fn bin_index(value: f64, centers: &Bounds, axis: usize) -> usize {
    let share = (value - centers.min[axis]) / (centers.max[axis] - centers.min[axis]);
    ((share * BINS as f64) as usize).min(BINS - 1)
}

/// The axis and bin border with the least cost by the surface area heuristic; `None` when all centers coincide.
fn cheapest_plane(pieces: &[TriangleEntry], centers: &Bounds) -> Option<(usize, usize)> {
    let mut best: Option<(f64, usize, usize)> = None;
    let step = (pieces.len() / SPLIT_SAMPLE).max(1);
    for axis in 0..3 {
        if centers.size()[axis] <= 0.0 {
            continue;
        }
        let mut bins = [(Bounds::EMPTY, 0usize); BINS];
        for piece in pieces.iter().step_by(step) {
            let bin = &mut bins[bin_index(piece.center[axis], centers, axis)];
            *bin = (join_bounds(bin.0, &piece.bounds), bin.1 + 1);
        }
        let mut costs = [0.0; BINS];
        let sweep = |costs: &mut [f64; BINS], order: &mut dyn Iterator<Item = (usize, usize)>| {
            let (mut bounds, mut count) = (Bounds::EMPTY, 0);
            for (take, plane) in order {
                (bounds, count) = (join_bounds(bounds, &bins[take].0), count + bins[take].1);
                costs[plane] += if count == 0 { f64::INFINITY } else { area(&bounds) * count as f64 };
            }
        };
        sweep(&mut costs, &mut (1..BINS).map(|plane| (plane - 1, plane)));
        sweep(&mut costs, &mut (1..BINS).rev().map(|plane| (plane, plane)));
        for (plane, &cost) in costs.iter().enumerate().skip(1) {
            if cost.is_finite() && best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, plane));
            }
        }
    }
    best.map(|(_, axis, plane)| (axis, plane))
}

fn area(bounds: &Bounds) -> f64 {
    let size = bounds.size();
    size.x * size.y + size.y * size.z + size.z * size.x
}

/// The connected shells of the surface: the shell of each vertex, and a vertex of each shell.
fn find_shells(mesh: &Mesh) -> (Vec<u32>, Vec<usize>) {
    let mut parent: Vec<u32> = (0..mesh.vertices().len() as u32).collect();
    fn root(parent: &mut [u32], mut v: u32) -> u32 {
        while parent[v as usize] != v {
            parent[v as usize] = parent[parent[v as usize] as usize];
            v = parent[v as usize];
        }
        v
    }
    for &[a, b, c] in mesh.triangles() {
        let a = root(&mut parent, a);
        for v in [b, c] {
            let v = root(&mut parent, v);
            parent[v as usize] = a;
        }
    }
    let mut number = vec![u32::MAX; parent.len()];
    let mut corners = Vec::new();
    let shell_of = (0..parent.len() as u32).map(|v| {
        let root = root(&mut parent, v) as usize;
        if number[root] == u32::MAX {
            number[root] = corners.len() as u32;
            corners.push(root);
        }
        number[root]
    });
    (shell_of.collect(), corners)
}
