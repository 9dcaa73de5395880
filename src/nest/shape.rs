//! Everything the search knows of one distinct mesh, prepared once and shared by all of its copies.

use std::sync::{Arc, Mutex, PoisonError, Weak};

use glam::{DQuat, DVec3};

use super::{body::Body, field::DistanceField, turns};
use crate::geometry::{ClearanceTree, Mesh, Pose};

/// A distinct mesh, prepared.
#[derive(Debug)]
pub(crate) struct Shape {
    /// Decides: exact distances.
    pub(crate) tree: Arc<ClearanceTree>,
    /// Middle of the smallest box, mesh frame, mm; the origin of all that follows.
    pub(crate) center: DVec3,
    /// Rotation of the smallest box.
    pub(crate) frame: DQuat,
    /// Points that decide the extents, less the center.
    pub(crate) extremes: Vec<DVec3>,
    /// The same, for the guides.
    pub(crate) extremes_f32: Vec<glam::Vec3>,
    /// Greatest distance of a point from the center, mm.
    pub(crate) radius_mm: f64,
    /// Guides: signed distance.
    pub(crate) field: DistanceField,
    /// Many surface points.
    pub(crate) fine: Body,
    /// Few surface points.
    pub(crate) coarse: Body,
    detail: Detail,
}

/// How finely a shape is prepared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Detail {
    /// Nodes of the distance grid, about.
    pub(crate) nodes: usize,
    /// Surface points, about.
    pub(crate) points: usize,
    /// How far the grid reaches beyond the mesh, mm.
    pub(crate) reach_mm: f64,
}

impl Detail {
    /// Whether what was prepared so is good enough for `wanted`.
    fn serves(&self, wanted: &Self) -> bool {
        self.nodes >= wanted.nodes && self.points >= wanted.points && self.reach_mm >= wanted.reach_mm
    }
}

impl Shape {
    fn new(tree: Arc<ClearanceTree>, detail: Detail) -> Self {
        let mesh = tree.mesh();
        let center = tree.obb().pose.translation;
        let extremes: Vec<DVec3> = turns::extreme_points(mesh.vertices(), 96).into_iter().map(|v| v - center).collect();
        let radius_mm = mesh.vertices().iter().map(|v| v.distance(center)).fold(0.0, f64::max);
        Self {
            center,
            frame: tree.obb().pose.rotation,
            radius_mm,
            extremes_f32: extremes.iter().map(|p| p.as_vec3()).collect(),
            extremes,
            field: DistanceField::new(mesh, center, detail.reach_mm, detail.nodes),
            fine: Body::new(mesh, center, detail.points),
            coarse: Body::new(mesh, center, 120),
            detail,
            tree,
        }
    }

    /// The pose of the mesh when its center stands at `place` after `turn`.
    pub(crate) fn pose(&self, turn: DQuat, place: DVec3) -> Pose {
        let turn = turn.normalize();
        Pose::new(turn, place - turn * self.center)
    }

    /// Where the center stands at a pose.
    pub(crate) fn place(&self, pose: &Pose) -> DVec3 {
        pose.point(self.center)
    }
}

/// Prepared shapes of meshes that are still alive: an open build asks for the same meshes again and again.
static PREPARED: Mutex<Vec<(Weak<Mesh>, Arc<Shape>)>> = Mutex::new(Vec::new());

/// The shape of a mesh at a detail or better, from what was prepared before where possible.
pub(crate) fn prepare(mesh: &Arc<Mesh>, detail: Detail) -> Arc<Shape> {
    let known = {
        let mut prepared = PREPARED.lock().unwrap_or_else(PoisonError::into_inner);
        // The shape itself holds its mesh; another holder means that somebody may still ask.
        prepared.retain(|(mesh, _)| mesh.strong_count() > 1);
        prepared.iter().find(|(known, _)| std::ptr::eq(known.as_ptr(), Arc::as_ptr(mesh))).map(|(_, s)| s.clone())
    };
    if let Some(shape) = known.as_ref().filter(|shape| shape.detail.serves(&detail)) {
        return shape.clone();
    }
    let tree = known.map_or_else(|| Arc::new(ClearanceTree::new(mesh.clone())), |shape| shape.tree.clone());
    let shape = Arc::new(Shape::new(tree, detail));
    let mut prepared = PREPARED.lock().unwrap_or_else(PoisonError::into_inner);
    prepared.retain(|(known, _)| !std::ptr::eq(known.as_ptr(), Arc::as_ptr(mesh)));
    prepared.push((Arc::downgrade(mesh), shape.clone()));
    shape
}
