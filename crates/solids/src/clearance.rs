//! The exact distance between two surfaces, capped at a bound: the kernel that decides whether two placements keep
//! their clearance. All boxes of a tree share the part's frame, so that a pair of trees is walked with one constant
//! relative rotation.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::{Bounds, Mesh, Obb, Pose, box_tree::BoxTree, inside, walk::Walk};

/// Surfaces nearer than this meet, mm: far above rounding, far below any printer.
const MEET_MM: f64 = 1e-9;

/// A box tree over a mesh's triangles. Built once per mesh, shared by all its copies.
#[derive(Debug, Clone)]
pub struct ClearanceTree {
    mesh: Arc<Mesh>,
    obb: Obb,
    pub(super) tree: BoxTree,
}

impl ClearanceTree {
    /// Builds the tree; time grows with n log n of the triangles.
    pub fn new(mesh: Arc<Mesh>) -> Self {
        let obb = Obb::smallest(&mesh);
        Self::along(mesh, obb)
    }

    /// The same, with boxes along `obb`, which was found before. Any box around the mesh gives right answers; a small one
    /// gives them sooner.
    pub fn along(mesh: Arc<Mesh>, obb: Obb) -> Self {
        let tree = BoxTree::new(&mesh, &obb.pose.inverse());
        Self { mesh, obb, tree }
    }

    /// The solid that the tree stands for.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// The smallest box found around the part, in the mesh's frame; its axes are those of every box in the tree, from long
    /// to short.
    pub fn obb(&self) -> &Obb {
        &self.obb
    }

    /// The least distance between the two surfaces, or `cap_mm` when they are further apart. 0 when the surfaces meet.
    /// Containment is not seen: see [`ClearanceTree::holds_part`]. `pose12` is the frame of `other` seen from this one.
    pub fn distance_capped_mm(&self, other: &Self, pose12: &Pose, cap_mm: f64) -> f64 {
        let found_sq = self.walk(other, pose12).nearest_sq(cap_mm * cap_mm, MEET_MM * MEET_MM);
        if found_sq <= MEET_MM * MEET_MM { 0.0 } else { found_sq.sqrt().min(cap_mm) }
    }

    /// Whether the surfaces meet or come nearer than `mm`; ends at the first pair of triangles that does.
    pub fn closer_than(&self, other: &Self, pose12: &Pose, mm: f64) -> bool {
        let cap = mm.max(MEET_MM);
        let cap_sq = cap * cap;
        self.walk(other, pose12).nearest_sq(cap_sq, cap_sq.next_down()) < cap_sq
    }

    /// Whether a point (mesh frame) lies inside the solid: whether the surface winds about it. A sealed cavity whose surface
    /// looks inwards is not inside. On the surface itself either answer may come.
    pub fn holds_point(&self, point: DVec3) -> bool {
        let point = self.to_box(point);
        inside::windings(&self.tree, point, self.mesh.defects().is_closed()).iter().sum::<i32>() > 0
    }

    /// Whether `other`, whose surface does not meet this one, lies inside this solid or inside a sealed cavity of it (from
    /// which it would never come out): whether any closed shell of this surface goes around any shell of the other.
    pub fn holds_part(&self, other: &Self, pose12: &Pose) -> bool {
        if !self.mesh.bounds().holds(&other.bounds_at(pose12), 0.0) && other.tree.shells().len() == 1 {
            return false;
        }
        other.tree.shells().iter().any(|&corner| {
            let point = self.to_box(pose12.point(other.obb.pose.point(corner)));
            self.tree.root_holds(point)
                && inside::windings(&self.tree, point, self.mesh.defects().is_closed()).iter().any(|&w| w != 0)
        })
    }

    /// Exact axis-aligned bounds of the mesh at a pose; much faster than [`Mesh::bounds_at`] on large meshes.
    pub fn bounds_at(&self, pose: &Pose) -> Bounds {
        let pose = pose.after(&self.obb.pose);
        let rows: DMat3 = pose.matrix().transpose();
        let reach = DVec3::from_array([rows.x_axis, rows.y_axis, rows.z_axis].map(|d| self.tree.reach(d)));
        let back = DVec3::from_array([rows.x_axis, rows.y_axis, rows.z_axis].map(|d| self.tree.reach(-d)));
        Bounds { min: pose.translation - back, max: pose.translation + reach }
    }

    /// How far the part reaches from the mesh frame's origin along a direction, in mm for a unit vector.
    pub fn reach_mm(&self, direction: DVec3) -> f64 {
        let direction_in_box = self.obb.pose.rotation.conjugate() * direction;
        self.tree.reach(direction_in_box) + self.obb.pose.translation.dot(direction)
    }

    /// Walks this tree and another one at once; `pose12` is the mesh frame of the other seen from this one.
    pub(super) fn walk<'a>(&'a self, other: &'a Self, pose12: &Pose) -> Walk<'a> {
        Walk::new(&self.tree, &other.tree, &self.obb.pose.inverse().after(&pose12.after(&other.obb.pose)))
    }

    /// A point of the mesh frame as the tree's boxes see it.
    fn to_box(&self, point: DVec3) -> DVec3 {
        self.obb.pose.inverse().point(point)
    }
}
