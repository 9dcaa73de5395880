//! A binary tree of boxes over the triangles of a mesh. All boxes are aligned with one frame; the triangles stay in the mesh
//! and in its frame, so that they are in memory once.

use std::sync::{Arc, OnceLock};

use glam::{DVec3, Vec3A};

use super::{
    Bounds, Mesh, Pose,
    box_tree_build::build_nodes,
    node_box::{TreeNodeBox, TreeNodeLink},
    normal_bounds::{NormalBounds, normals_below},
    shells::{MeshShells, find_shells},
    triangle::Triangle,
    triangle_lanes::{TriangleLaneStore, TriangleLanes},
};

/// A tree over at most so many triangles keeps them ready, in the order of its leaves, with their normals and once more in
/// single precision: 132 bytes a triangle, which makes answers faster. Of larger meshes, whose memory counts, triangles are
/// taken from the mesh.
const MAX_READY_TRIANGLES: usize = 50_000;

/// The tree.
#[derive(Debug, Clone)]
pub(super) struct TriangleBoxTree {
    mesh: Arc<Mesh>,
    pub boxes: Vec<TreeNodeBox>,
    pub links: Vec<TreeNodeLink>,
    /// The mesh's triangles in the order of the leaves.
    order: Vec<u32>,
    /// The triangles in the order of the leaves; empty for a large mesh.
    ready: Vec<Triangle>,
    lanes: TriangleLaneStore,
    to_box: Pose,
    /// The exact box around the mesh in the frame of the boxes.
    bounds: Bounds,
    /// Known once they are asked for.
    normals: OnceLock<Vec<NormalBounds>>,
    shells: OnceLock<MeshShells>,
}

impl TriangleBoxTree {
    /// Builds the tree over a mesh on at most `threads` threads; `to_box` transforms the mesh to the frame of the boxes.
    pub fn new(mesh: Arc<Mesh>, to_box: &Pose, threads: usize) -> Self {
        let built = build_nodes(&mesh, to_box, threads);
        let ready = match mesh.triangles().len() {
            0..=MAX_READY_TRIANGLES => {
                built.order.iter().map(|&index| Triangle::new(mesh.corners(index as usize))).collect()
            }
            _ => Vec::new(),
        };
        Self {
            mesh,
            lanes: TriangleLaneStore::new(&ready, to_box),
            to_box: *to_box,
            ready,
            boxes: built.boxes,
            links: built.links,
            order: built.order,
            bounds: built.bounds,
            normals: OnceLock::new(),
            shells: OnceLock::new(),
        }
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// The corners of a triangle in the mesh's frame, by its place in the order of the leaves.
    #[inline]
    pub fn corners(&self, place: usize) -> [DVec3; 3] {
        match self.ready.get(place) {
            Some(triangle) => triangle.corners,
            None => self.mesh.corners(self.order[place] as usize),
        }
    }

    /// A triangle in the mesh's frame, by its place in the order of the leaves.
    #[inline]
    pub fn triangle(&self, place: usize) -> Triangle {
        match self.ready.get(place) {
            Some(triangle) => *triangle,
            None => Triangle::new(self.mesh.corners(self.order[place] as usize)),
        }
    }

    /// A triangle that is ready, by its place in the order of the leaves.
    #[inline]
    pub fn ready_triangle(&self, place: usize) -> Option<&Triangle> {
        self.ready.get(place)
    }

    /// The triangles of a leaf in the frame of the boxes.
    #[inline]
    pub fn leaf_lanes(&self, leaf: TreeNodeLink) -> TriangleLanes {
        let places = leaf.triangle_range();
        if self.ready.is_empty() {
            let (rotation, shift) = (self.to_box.rotation_matrix(), self.to_box.translation);
            return TriangleLanes::of_corners(places.map(|place| self.corners(place).map(|c| rotation * c + shift)));
        }
        self.lanes.lanes_from(places.start)
    }

    /// Bounds of the triangle normals below each node, in the mesh's frame.
    pub fn normal_bounds(&self) -> &[NormalBounds] {
        self.normals.get_or_init(|| normals_below(&self.links, |place| self.triangle(place)))
    }

    /// The connected shells of the surface.
    fn shells(&self) -> &MeshShells {
        self.shells.get_or_init(|| find_shells(&self.mesh))
    }

    /// A corner of each connected shell, in the mesh's frame.
    pub fn shell_corners(&self) -> impl ExactSizeIterator<Item = DVec3> {
        self.shells().first_vertices().iter().map(|&vertex| self.mesh.vertices()[vertex as usize])
    }

    /// The shell to which a triangle belongs, by its place in the order of the leaves.
    pub fn shell_of(&self, place: usize) -> usize {
        self.shells().shell_of_vertex(self.mesh.triangles()[self.order[place] as usize][0])
    }

    /// Whether the root box contains a point of the frame of the boxes.
    pub fn root_contains(&self, point: DVec3) -> bool {
        point.cmpge(self.bounds.min).all() && point.cmple(self.bounds.max).all()
    }

    /// The greatest dot product of a vertex with `direction` (both in the mesh's frame), by branch and bound;
    /// `direction_in_box` is the same direction in the frame of the boxes, and `shift` what is added to a dot product in
    /// that frame. Exact up to rounding: boxes that could improve the result only by rounding are skipped, since otherwise
    /// all corners of a flat face would be tested.
    pub fn support_value(&self, direction: DVec3, direction_in_box: DVec3, shift: f64) -> f64 {
        let size = self.bounds.size().max(self.bounds.min.abs()).max(self.bounds.max.abs());
        let slack = 1e-13 * (size.dot(direction_in_box.abs()) + shift.abs());
        let way = direction_in_box.as_vec3a();
        let mut search = SupportSearch {
            tree: self,
            direction,
            direction_in_box,
            way,
            spread: way.abs(),
            // More than the rounding of the single precision below.
            margin: 1e-6 * size.element_sum(),
            shift,
            slack,
            best: f64::NEG_INFINITY,
        };
        search.visit_node(0);
        search.best
    }
}

/// A search for the vertex that reaches farthest.
struct SupportSearch<'a> {
    tree: &'a TriangleBoxTree,
    direction: DVec3,
    direction_in_box: DVec3,
    way: Vec3A,
    spread: Vec3A,
    margin: f64,
    shift: f64,
    slack: f64,
    best: f64,
}

impl SupportSearch<'_> {
    fn visit_node(&mut self, node: usize) {
        let link = self.tree.links[node];
        if link.is_leaf() {
            for place in link.triangle_range() {
                let corners = self.tree.corners(place);
                self.best = corners.iter().fold(self.best, |best, c| best.max(c.dot(self.direction)));
            }
            return;
        }
        let children = [link.first_child(), link.first_child() + 1];
        let bounds = children.map(|child| self.about_reach_of(child));
        let order = if bounds[0] >= bounds[1] { [0, 1] } else { [1, 0] };
        for i in order {
            if bounds[i] > self.best && self.reach_of(children[i]) > self.best + self.slack {
                self.visit_node(children[i]);
            }
        }
    }

    /// How far the box of a node reaches, a little more than exactly.
    #[inline]
    fn about_reach_of(&self, node: usize) -> f64 {
        let TreeNodeBox { center, half } = self.tree.boxes[node];
        f64::from((center * self.way + half * self.spread).element_sum()) + self.margin + self.shift
    }

    /// How far the box of a node reaches. The sides of the root are exact, so that a flat face on one of them does not
    /// seem to reach beyond itself.
    fn reach_of(&self, node: usize) -> f64 {
        let (min, max) = self.tree.boxes[node].corners_within(&self.tree.bounds);
        let way = self.direction_in_box;
        DVec3::select(way.cmpge(DVec3::ZERO), max, min).dot(way) + self.shift
    }
}
