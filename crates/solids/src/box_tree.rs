//! A binary tree of boxes over triangles, all boxes along one frame.

use glam::{DVec3, Vec3};

use super::{Bounds, Mesh, Pose, triangle::Triangle};

/// Most triangles in a leaf: below that, walking boxes costs more than it saves.
pub(super) const LEAF: usize = 4;
/// Places at which a split is tried along an axis.
const BINS: usize = 16;
/// Where there are more triangles, some of them stand for all when a split is chosen.
const ENOUGH: usize = 2048;
/// Below this depth nodes are halved by count, so that a walk is never deeper than twice about 40.
const MAX_UNEVEN_DEPTH: usize = 24;

/// A box and what is in it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    /// Middle of the box, mm.
    pub center: DVec3,
    /// Half the edge lengths, mm.
    pub half: DVec3,
    /// First triangle of a leaf, or the first of the two children, which stand side by side.
    pub first: u32,
    /// Triangles of a leaf; 0 for an inner node.
    pub count: u32,
}

impl Node {
    /// The triangles of a leaf.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }

    /// Whether there are triangles and no children.
    pub fn is_leaf(&self) -> bool {
        self.count > 0
    }
}

/// The tree, with the triangles in the order of its leaves and in its own frame.
#[derive(Debug, Clone)]
pub(super) struct BoxTree {
    pub nodes: Vec<Node>,
    pub triangles: Vec<Triangle>,
    /// Which ways the triangles of each node face.
    pub facings: Vec<Facing>,
    /// Which connected piece of the surface a triangle belongs to.
    pub shell_of: Vec<u32>,
    /// A corner of each connected piece.
    shells: Vec<DVec3>,
}

impl BoxTree {
    /// Builds the tree over a mesh in the frame that `to_box` leads to.
    pub fn new(mesh: &Mesh, to_box: &Pose) -> Self {
        let places: Vec<DVec3> = mesh.vertices().iter().map(|&v| to_box.point(v)).collect();
        let turn = to_box.matrix();
        let (shell_of_vertex, shells) = shells(mesh);
        let mut pieces: Vec<Piece> = (mesh.triangles().iter().enumerate())
            .map(|(index, corners)| Piece::new(index as u32, corners.map(|v| places[v as usize])))
            .collect();
        let mut nodes = vec![Node { center: DVec3::ZERO, half: DVec3::ZERO, first: 0, count: 0 }];
        build(&mut nodes, &mut pieces, 0, 0, 0);
        let triangle = |piece: &Piece| {
            let index = piece.index as usize;
            // The normal comes from the corners as given: turning them first would round a sliver's away.
            let normal = turn * Triangle::new(mesh.corners(index)).normal;
            Triangle { corners: mesh.triangles()[index].map(|v| places[v as usize]), normal }
        };
        let shell = |piece: &Piece| shell_of_vertex[mesh.triangles()[piece.index as usize][0] as usize];
        let triangles: Vec<Triangle> = pieces.iter().map(triangle).collect();
        Self {
            facings: facings(&nodes, &triangles),
            triangles,
            shell_of: pieces.iter().map(shell).collect(),
            shells: shells.into_iter().map(|v| places[v]).collect(),
            nodes,
        }
    }

    /// A corner of each connected piece of the surface.
    pub fn shells(&self) -> &[DVec3] {
        &self.shells
    }

    /// Whether the outermost box holds a point.
    pub fn root_holds(&self, point: DVec3) -> bool {
        let root = &self.nodes[0];
        (point - root.center).abs().cmple(root.half).all()
    }

    /// The greatest dot product of a corner with `direction`, by branch and bound. Exact to rounding: boxes that could
    /// better the best by rounding only are passed by, or a flat face would have all its corners looked at.
    pub fn reach(&self, direction: DVec3) -> f64 {
        let mut best = f64::NEG_INFINITY;
        let slack = 1e-13 * self.nodes[0].half.dot(direction.abs());
        self.reach_in(0, direction, slack, &mut best);
        best
    }

    fn reach_in(&self, node: usize, direction: DVec3, slack: f64, best: &mut f64) {
        let node = &self.nodes[node];
        if node.is_leaf() {
            for triangle in &self.triangles[node.range()] {
                *best = triangle.corners.iter().fold(*best, |best, c| best.max(c.dot(direction)));
            }
            return;
        }
        let children = [node.first as usize, node.first as usize + 1];
        let bounds = children.map(|c| self.nodes[c].center.dot(direction) + self.nodes[c].half.dot(direction.abs()));
        let order = if bounds[0] >= bounds[1] { [0, 1] } else { [1, 0] };
        for i in order {
            if bounds[i] > *best + slack {
                self.reach_in(children[i], direction, slack, best);
            }
        }
    }
}

/// Bounds of unit normals; single precision, grown by more than its rounding.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facing {
    middle: Vec3,
    half: Vec3,
}

impl Facing {
    /// The least and the greatest dot product that a normal may have with `direction`, whose absolute values are `spread`.
    #[inline]
    pub fn along(&self, direction: Vec3, spread: Vec3) -> (f32, f32) {
        let (middle, half) = (self.middle.dot(direction), self.half.dot(spread));
        (middle - half, middle + half)
    }
}

/// The bounds of the normals below every node; children stand after their parents.
fn facings(nodes: &[Node], triangles: &[Triangle]) -> Vec<Facing> {
    const GROWN: f32 = 1e-6;
    let mut limits = vec![(Vec3::INFINITY, Vec3::NEG_INFINITY); nodes.len()];
    for (at, node) in nodes.iter().enumerate().rev() {
        let join = |a: (Vec3, Vec3), b: (Vec3, Vec3)| (a.0.min(b.0), a.1.max(b.1));
        limits[at] = if node.is_leaf() {
            let own = |triangle: &Triangle| match triangle.normal {
                // What has no normal may face anywhere.
                DVec3::ZERO => (Vec3::NEG_ONE, Vec3::ONE),
                normal => (normal.as_vec3(), normal.as_vec3()),
            };
            triangles[node.range()].iter().map(own).fold(limits[at], join)
        } else {
            join(limits[node.first as usize], limits[node.first as usize + 1])
        };
    }
    let facing = |(min, max): (Vec3, Vec3)| Facing { middle: (min + max) * 0.5, half: (max - min) * 0.5 + GROWN };
    limits.into_iter().map(facing).collect()
}

/// A triangle while the tree is being built.
struct Piece {
    index: u32,
    bounds: Bounds,
    center: DVec3,
}

impl Piece {
    fn new(index: u32, corners: [DVec3; 3]) -> Self {
        let bounds = Bounds::around(corners);
        Self { index, center: bounds.center(), bounds }
    }
}

fn join(one: Bounds, two: &Bounds) -> Bounds {
    Bounds { min: one.min.min(two.min), max: one.max.max(two.max) }
}

/// Fills node `at` with `pieces`, the first of which has place `first` in the tree's order.
fn build(nodes: &mut Vec<Node>, pieces: &mut [Piece], at: usize, first: usize, depth: usize) {
    let bounds = pieces.iter().fold(Bounds::EMPTY, |all, p| join(all, &p.bounds));
    let center = bounds.center();
    // Rounding of the middle must not leave a corner outside.
    let half = (bounds.max - center).max(center - bounds.min);
    if pieces.len() <= LEAF {
        nodes[at] = Node { center, half, first: first as u32, count: pieces.len() as u32 };
        return;
    }
    let middle = split(pieces, depth);
    let child = nodes.len();
    nodes[at] = Node { center, half, first: child as u32, count: 0 };
    nodes.extend([nodes[at]; 2]);
    let (left, right) = pieces.split_at_mut(middle);
    build(nodes, left, child, first, depth + 1);
    build(nodes, right, child + 1, first + middle, depth + 1);
}

/// Orders the pieces into two groups and returns the size of the first.
fn split(pieces: &mut [Piece], depth: usize) -> usize {
    let centers = Bounds::around(pieces.iter().map(|p| p.center));
    let best = if depth < MAX_UNEVEN_DEPTH { cheapest_plane(pieces, &centers) } else { None };
    if let Some((axis, plane)) = best {
        let mut middle = 0;
        for i in 0..pieces.len() {
            if bin(pieces[i].center[axis], &centers, axis) < plane {
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

fn bin(value: f64, centers: &Bounds, axis: usize) -> usize {
    let share = (value - centers.min[axis]) / (centers.max[axis] - centers.min[axis]);
    ((share * BINS as f64) as usize).min(BINS - 1)
}

/// The axis and bin border with the least surface area heuristic; `None` when all centres coincide.
fn cheapest_plane(pieces: &[Piece], centers: &Bounds) -> Option<(usize, usize)> {
    let mut best: Option<(f64, usize, usize)> = None;
    let step = (pieces.len() / ENOUGH).max(1);
    for axis in 0..3 {
        if centers.size()[axis] <= 0.0 {
            continue;
        }
        let mut bins = [(Bounds::EMPTY, 0usize); BINS];
        for piece in pieces.iter().step_by(step) {
            let bin = &mut bins[bin(piece.center[axis], centers, axis)];
            *bin = (join(bin.0, &piece.bounds), bin.1 + 1);
        }
        let mut costs = [0.0; BINS];
        let sweep = |costs: &mut [f64; BINS], order: &mut dyn Iterator<Item = (usize, usize)>| {
            let (mut bounds, mut count) = (Bounds::EMPTY, 0);
            for (take, plane) in order {
                (bounds, count) = (join(bounds, &bins[take].0), count + bins[take].1);
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

/// The connected pieces of the surface: which one each vertex belongs to, and a vertex of each.
fn shells(mesh: &Mesh) -> (Vec<u32>, Vec<usize>) {
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
