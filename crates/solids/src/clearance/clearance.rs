//! The exact distance between two surfaces, capped at a bound: the kernel that decides whether two placements keep
//! their clearance. All boxes of a tree are aligned with the part's frame, so a pair of trees is traversed with one
//! constant relative rotation.

use std::sync::{Arc, OnceLock};

use glam::DVec3;

use crate::{
    Bounds, Mesh, Obb, Pose,
    trees::{
        box_tree::TriangleBoxTree,
        extreme_points::PointCells,
        tree_pair_walk::{MEET_MM, TreePairWalk},
        winding_number,
    },
};

/// A box tree over a mesh's triangles. Built once per mesh, shared by all its copies; the triangles stay in the mesh.
#[derive(Debug, Clone)]
pub struct ClearanceTree {
    obb: Obb,
    pub(crate) tree: TriangleBoxTree,
    /// Known once bounds are asked for.
    vertex_cells: OnceLock<PointCells>,
}

impl ClearanceTree {
    /// Builds the tree on this thread; time grows with n log n of the triangles.
    pub fn new(mesh: Arc<Mesh>) -> Self {
        Self::on_threads(mesh, 1)
    }

    /// Builds the tree on at most `threads` threads. It is the same for any number of them.
    pub fn on_threads(mesh: Arc<Mesh>, threads: usize) -> Self {
        let obb = Obb::smallest_around(&mesh);
        Self::with_obb(mesh, obb, threads)
    }

    /// The same, with boxes along a known `obb`. Any box around the mesh gives correct results; a small one is faster.
    pub fn with_obb(mesh: Arc<Mesh>, obb: Obb, threads: usize) -> Self {
        let tree = TriangleBoxTree::new(mesh, &obb.pose.inverse(), threads);
        Self { obb, tree, vertex_cells: OnceLock::new() }
    }

    /// The mesh of the tree.
    pub fn mesh(&self) -> &Arc<Mesh> {
        self.tree.mesh()
    }

    /// The smallest box found around the part, in the mesh's frame. All boxes of the tree have its axes, from long to
    /// short.
    pub fn obb(&self) -> &Obb {
        &self.obb
    }

    /// The least distance between the two surfaces, or `cap_mm` when they are further apart. 0 when the surfaces meet.
    /// Containment is not detected: see [`ClearanceTree::contains_part`]. `pose12` is the frame of `other` seen from this
    /// one.
    pub fn distance_capped_mm(&self, other: &Self, pose12: &Pose, cap_mm: f64) -> f64 {
        let found_sq = self.pair_walk(other, pose12).nearest_sq(cap_mm * cap_mm, MEET_MM * MEET_MM);
        if found_sq <= MEET_MM * MEET_MM { 0.0 } else { found_sq.sqrt().min(cap_mm) }
    }

    /// Whether the surfaces meet or come nearer than `mm`; stops at the first such pair of triangles.
    pub fn is_closer_than(&self, other: &Self, pose12: &Pose, mm: f64) -> bool {
        let cap = mm.max(MEET_MM);
        let cap_sq = cap * cap;
        self.pair_walk(other, pose12).nearest_sq(cap_sq, cap_sq.next_down()) < cap_sq
    }

    /// Whether a point (mesh frame) lies inside the solid, by the winding number of the surface. The inside of a sealed
    /// cavity is not inside the solid. On the surface itself the result is undefined.
    pub fn contains_point(&self, point: DVec3) -> bool {
        self.windings_about(point).iter().sum::<i32>() > 0
    }

    /// Whether `other`, whose surface does not meet this one, lies inside this solid or inside a sealed cavity of it
    /// (which it could never leave): whether any closed shell of this surface encloses any shell of the other.
    pub fn contains_part(&self, other: &Self, pose12: &Pose) -> bool {
        let mut corners = other.tree.shell_corners();
        if !self.mesh().bounds().contains_bounds(&other.bounds_at(pose12), 0.0) && corners.len() == 1 {
            return false;
        }
        corners.any(|corner| {
            let point = pose12.transform_point(corner);
            self.tree.root_contains(self.obb.pose.inverse().transform_point(point))
                && self.windings_about(point).iter().any(|&w| w != 0)
        })
    }

    /// The winding number of each shell about a point (mesh frame).
    fn windings_about(&self, point: DVec3) -> Vec<i32> {
        winding_number::winding_numbers(&self.tree, &self.obb.pose, point, self.mesh().defects().is_closed())
    }

    /// Exact axis-aligned bounds of the mesh at a pose; much faster than [`Mesh::bounds_at`] on large meshes.
    pub fn bounds_at(&self, pose: &Pose) -> Bounds {
        let rows = pose.rotation_matrix().transpose();
        let reach = |direction: DVec3| self.reach_mm(direction);
        let max = DVec3::new(reach(rows.x_axis), reach(rows.y_axis), reach(rows.z_axis));
        let min = DVec3::new(-reach(-rows.x_axis), -reach(-rows.y_axis), -reach(-rows.z_axis));
        Bounds { min: pose.translation + min, max: pose.translation + max }
    }

    /// How far the part reaches from the mesh frame's origin along a direction, in mm for a unit vector.
    pub fn reach_mm(&self, direction: DVec3) -> f64 {
        let vertices = self.mesh().vertices();
        let cells = self.vertex_cells.get_or_init(|| PointCells::new(vertices));
        cells.farthest_point(vertices, direction).map_or(0.0, |(reach, _)| reach)
    }

    /// A simultaneous traversal of this tree and another one; `pose12` is the mesh frame of the other seen from this
    /// one.
    pub(super) fn pair_walk<'a>(&'a self, other: &'a Self, pose12: &Pose) -> TreePairWalk<'a> {
        let boxes12 = self.obb.pose.inverse().compose_with(&pose12.compose_with(&other.obb.pose));
        TreePairWalk::new(&self.tree, &other.tree, pose12, &boxes12)
    }
}
