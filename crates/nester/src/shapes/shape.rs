//! The prepared data of one distinct mesh, shared by all of its copies.

use std::sync::Arc;

use glam::{DQuat, DVec3};
use solids::{ClearanceTree, Pose};

use super::{
    cache::{self, PreparedMeshCache},
    distance_field::DistanceField,
    outline::MeshOutline,
    point_block::{BLOCK_POINTS, PointBlock},
    sphere_tree::{MeasuredSurface, SphereTree},
};

/// Number of points of the coarse set, by which candidates are compared.
const FEW_POINTS: usize = 120;

/// A distinct mesh, prepared.
#[derive(Debug)]
pub(crate) struct PreparedShape {
    /// Exact distances; these decide validity.
    pub(crate) tree: Arc<ClearanceTree>,
    /// Center of the smallest box, mesh frame, mm; the origin of all that follows.
    pub(crate) center: DVec3,
    /// Rotation of the smallest box.
    pub(crate) frame: DQuat,
    /// Points that determine the extents, relative to the center.
    pub(crate) extremes: Vec<DVec3>,
    /// The same points in single precision, for the proxies.
    pub(crate) extremes_f32: Vec<glam::Vec3>,
    /// These again, side by side.
    pub(crate) extreme_blocks: Vec<PointBlock>,
    /// Greatest distance of a point from the center, mm.
    pub(crate) radius_mm: f64,
    /// Signed distance grid, for the proxies.
    pub(crate) distance_field: DistanceField,
    /// Fine set of surface points.
    pub(crate) fine_points: SphereTree,
    /// Coarse set of surface points.
    pub(crate) coarse_points: SphereTree,
}

/// How finely a shape is prepared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ShapeDetail {
    /// Approximate number of nodes of the distance grid.
    pub(crate) nodes: usize,
    /// Approximate number of surface points.
    pub(crate) points: usize,
    /// Distance by which the grid reaches beyond the mesh, mm.
    pub(crate) reach_mm: f64,
}

impl PreparedShape {
    /// Computes the collision proxy, or takes it from the cache under the mesh's content hash; `None` when the time
    /// runs out first.
    pub(crate) fn new(
        tree: Arc<ClearanceTree>,
        outline: &MeshOutline,
        detail: ShapeDetail,
        kept: Option<(&dyn PreparedMeshCache, &str)>,
        is_over: &dyn Fn() -> bool,
    ) -> Option<Self> {
        let center = outline.obb.pose.translation;
        let (field, fine, coarse) = prepare_proxies(&tree, center, detail, kept, is_over)?;
        let extremes_f32: Vec<glam::Vec3> = outline.extremes.iter().map(|p| p.as_vec3()).collect();
        Some(Self {
            center,
            frame: outline.obb.pose.rotation,
            radius_mm: outline.radius_mm,
            extreme_blocks: extremes_f32.chunks(BLOCK_POINTS).map(PointBlock::from_points).collect(),
            extremes_f32,
            extremes: outline.extremes.clone(),
            distance_field: field,
            fine_points: fine,
            coarse_points: coarse,
            tree,
        })
    }

    /// The pose of the mesh when its center is at `place` after the rotation `turn`.
    pub(crate) fn mesh_pose(&self, turn: DQuat, place: DVec3) -> Pose {
        let turn = turn.normalize();
        Pose::new(turn, place - turn * self.center)
    }

    /// Position of the center at a pose.
    pub(crate) fn center_at(&self, pose: &Pose) -> DVec3 {
        pose.transform_point(self.center)
    }
}

fn prepare_proxies(
    tree: &ClearanceTree,
    center: DVec3,
    detail: ShapeDetail,
    kept: Option<(&dyn PreparedMeshCache, &str)>,
    is_over: &dyn Fn() -> bool,
) -> Option<(DistanceField, SphereTree, SphereTree)> {
    let kind = || format!("guides-{}-{}-{:016x}", detail.nodes, detail.points, detail.reach_mm.to_bits());
    let slot = kept.map(|(cache, name)| (cache, cache::cache_key(&kind(), name)));
    let known = slot.as_ref().and_then(|(cache, key)| cache::unpack_proxies(&cache.fetch_bytes(key)?));
    if known.is_some() {
        return known;
    }
    let mesh = tree.mesh();
    let field = DistanceField::new(mesh, center, detail.reach_mm, detail.nodes, is_over)?;
    if is_over() {
        return None;
    }
    let surface = MeasuredSurface::new(mesh);
    let (fine, coarse) =
        (SphereTree::new(&surface, center, detail.points), SphereTree::new(&surface, center, FEW_POINTS));
    if let Some((cache, key)) = slot {
        cache.store_bytes(&key, &cache::pack_proxies(&field, &fine, &coarse));
    }
    Some((field, fine, coarse))
}
