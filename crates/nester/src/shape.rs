//! Everything the search knows of one distinct mesh, shared by all of its copies.

use std::sync::Arc;

use glam::{DQuat, DVec3};
use solids::{ClearanceTree, Pose};

use super::{
    body::Body,
    cache::{self, Cache},
    field::DistanceField,
    outline::Outline,
};

/// Points of the few by which candidates are compared.
const FEW_POINTS: usize = 120;

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

impl Shape {
    /// Works out the guides, or takes them from what was kept under the mesh's name; `None` when the time is over before.
    pub(crate) fn new(
        tree: Arc<ClearanceTree>,
        outline: &Outline,
        detail: Detail,
        kept: Option<(&dyn Cache, &str)>,
        is_over: &dyn Fn() -> bool,
    ) -> Option<Self> {
        let center = outline.obb.pose.translation;
        let (field, fine, coarse) = guides(&tree, center, detail, kept, is_over)?;
        Some(Self {
            center,
            frame: outline.obb.pose.rotation,
            radius_mm: outline.radius_mm,
            extremes_f32: outline.extremes.iter().map(|p| p.as_vec3()).collect(),
            extremes: outline.extremes.clone(),
            field,
            fine,
            coarse,
            tree,
        })
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

fn guides(
    tree: &ClearanceTree,
    center: DVec3,
    detail: Detail,
    kept: Option<(&dyn Cache, &str)>,
    is_over: &dyn Fn() -> bool,
) -> Option<(DistanceField, Body, Body)> {
    let kind = || format!("guides-{}-{}-{:016x}", detail.nodes, detail.points, detail.reach_mm.to_bits());
    let slot = kept.map(|(cache, name)| (cache, cache::key_of(&kind(), name)));
    let known = slot.as_ref().and_then(|(cache, key)| cache::unpack_guides(&cache.fetch(key)?));
    if known.is_some() {
        return known;
    }
    let mesh = tree.mesh();
    let field = DistanceField::new(mesh, center, detail.reach_mm, detail.nodes, is_over)?;
    if is_over() {
        return None;
    }
    let (fine, coarse) = (Body::new(mesh, center, detail.points), Body::new(mesh, center, FEW_POINTS));
    if let Some((cache, key)) = slot {
        cache.keep(&key, &cache::pack_guides(&field, &fine, &coarse));
    }
    Some((field, fine, coarse))
}
