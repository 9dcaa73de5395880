//! A binary tree of boxes over the triangles of a mesh. All boxes are aligned with one frame; the triangles stay in the mesh
//! and in its frame, so that they are in memory once.

use std::sync::{Arc, OnceLock};

use glam::DVec3;

use super::{
    box_tree_build::build_nodes,
    node_box::{TreeNodeBox, TreeNodeLink},
    normal_bounds::{NormalBounds, normals_below},
    triangle_lanes::{TriangleLaneStore, TriangleLanes},
};
use crate::{
    Bounds, Mesh, Pose,
    mesh::{
        shells::{MeshShells, find_shells},
        triangle::Triangle,
    },
};

/// A tree over at most so many triangles keeps them ready, in the order of its leaves, with their normals and once more in
/// single precision: 132 bytes a triangle, which makes answers faster. Of larger meshes, whose memory counts, triangles are
/// taken from the mesh.
const MAX_READY_TRIANGLES: usize = 50_000;

/// The tree.
#[derive(Debug, Clone)]
pub(crate) struct TriangleBoxTree {
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
}
