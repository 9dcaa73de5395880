//! The outline of a mesh: its smallest box and the points that determine its extents. This is enough to stack boxes,
//! and all that a first layout waits for.

use std::sync::Arc;

use glam::{DQuat, DVec3};
use solids::{Mesh, Obb};

use crate::{
    LayerAreaCap, NestingInstance, OrientationLimits,
    orientation::rotations,
    problem::{fit_check, reserved::ReservedZone},
};

/// Number of directions whose farthest points determine a part's extents almost exactly.
const DIRECTIONS: usize = 96;

/// The outline of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MeshOutline {
    /// The smallest box found.
    pub(crate) obb: Obb,
    /// Points that determine the extents, relative to the box's center, mm.
    pub(crate) extremes: Vec<DVec3>,
    /// Greatest distance of a point from the box's center, mm.
    pub(crate) radius_mm: f64,
}

impl MeshOutline {
    /// Measures a mesh. Time grows with its vertices.
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let obb = Obb::smallest_around(mesh);
        let center = obb.pose.translation;
        let extremes = rotations::extreme_points(mesh.vertices(), DIRECTIONS).into_iter().map(|v| v - center).collect();
        let radius_mm = mesh.vertices().iter().map(|v| v.distance_squared(center)).fold(0.0, f64::max).sqrt();
        Self { obb, extremes, radius_mm }
    }
}

/// An item that fits the volume, with its outline.
#[derive(Debug, Clone)]
pub(crate) struct OutlinedItem {
    pub(crate) mesh: Arc<Mesh>,
    pub(crate) outline: Arc<MeshOutline>,
    pub(crate) orientation: OrientationLimits,
    /// Clearance required for this item, mm. Between two items the greater one applies.
    pub(crate) clearance_mm: f64,
    /// A rotation in which the item fits into the volume.
    pub(crate) fitting_rotation: DQuat,
}

/// The outlines of all items of an instance; `None` for items that fit in no allowed orientation.
#[derive(Debug, Clone)]
pub(crate) struct OutlinedInstance {
    pub(crate) outlined_items: Vec<Option<OutlinedItem>>,
    /// All copies that fit into the empty volume, in order of precedence.
    pub(crate) copies: Vec<(usize, u32)>,
    pub(crate) room: DVec3,
    /// The greatest clearance of any item, mm.
    pub(crate) max_clearance_mm: f64,
    /// Keep-out zones.
    pub(crate) zones: Vec<ReservedZone>,
    /// Clearances must also hold when either part is raised by up to this, mm.
    pub(crate) z_extra_mm: f64,
    /// Layer thickness, and the greatest area that a layer may fill.
    pub(crate) layer_cap: LayerAreaCap,
}

impl OutlinedInstance {
    /// Outlines every item; `outlines` returns the outlines of meshes, in their order.
    pub(crate) fn new(instance: &NestingInstance, outlines: impl Fn(&[Arc<Mesh>]) -> Vec<Arc<MeshOutline>>) -> Self {
        let own = |item: &crate::NestingItem| item.clearance_mm.unwrap_or(0.0).max(instance.clearance_mm());
        let fitting = |item: &crate::NestingItem| {
            fit_check::find_fitting_rotation(&item.mesh, &item.orientation, &instance.volume()).ok()
        };
        let fittings: Vec<Option<DQuat>> = instance.items().iter().map(fitting).collect();
        let standing =
            || instance.items().iter().zip(&fittings).filter_map(|(item, fitting)| Some((item, (*fitting)?)));
        let meshes: Vec<Arc<Mesh>> = standing().map(|(item, _)| item.mesh.clone()).collect();
        let mut outlines = outlines(&meshes).into_iter();
        let candidate = |(item, fitting): (&crate::NestingItem, &Option<DQuat>)| {
            Some(OutlinedItem {
                fitting_rotation: (*fitting)?,
                mesh: item.mesh.clone(),
                outline: outlines.next()?,
                orientation: item.orientation.clone(),
                clearance_mm: own(item),
            })
        };
        let candidates: Vec<Option<OutlinedItem>> = instance.items().iter().zip(&fittings).map(candidate).collect();
        let copies = (instance.items().iter().enumerate())
            .filter(|&(at, _)| candidates[at].is_some())
            .flat_map(|(at, item)| (0..item.copies).map(move |copy| (at, copy)))
            .collect();
        let reach_mm = instance.items().iter().map(own).fold(0.0, f64::max);
        let zones = instance.reserved_space().zones.clone();
        let z_extra_mm = instance.clearance_z_extra_mm();
        let (room, cap) = (instance.volume().size_mm, instance.layer_cap());
        Self { outlined_items: candidates, copies, room, max_clearance_mm: reach_mm, z_extra_mm, zones, layer_cap: cap }
    }

    /// The item of a copy that fits.
    pub(crate) fn outlined_item(&self, item: usize) -> &OutlinedItem {
        self.outlined_items[item].as_ref().expect("only items that fit are nested")
    }
}
