//! What is known of a mesh from outside: its smallest box and the points that decide its extents. Enough for boxes on
//! boxes, and all that a first layout waits for.

use std::sync::Arc;

use glam::{DQuat, DVec3};
use solids::{Mesh, Obb};

use super::{Instance, LayerCap, Orientation, fit, reserved::Zone, turns};

/// Directions whose farthest points decide a part's extents, all but exactly.
const DIRECTIONS: usize = 96;

/// A mesh from outside.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Outline {
    /// The smallest box found.
    pub(crate) obb: Obb,
    /// Points that decide the extents, less the box's middle, mm.
    pub(crate) extremes: Vec<DVec3>,
    /// Greatest distance of a point from the box's middle, mm.
    pub(crate) radius_mm: f64,
}

impl Outline {
    /// Looks at a mesh. Time grows with its vertices.
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let obb = Obb::smallest(mesh);
        let center = obb.pose.translation;
        let extremes = turns::extreme_points(mesh.vertices(), DIRECTIONS).into_iter().map(|v| v - center).collect();
        let radius_mm = mesh.vertices().iter().map(|v| v.distance_squared(center)).fold(0.0, f64::max).sqrt();
        Self { obb, extremes, radius_mm }
    }
}

/// An item that fits the volume, seen from outside.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    pub(crate) mesh: Arc<Mesh>,
    pub(crate) outline: Arc<Outline>,
    pub(crate) orientation: Orientation,
    /// Clearance asked for it, mm; between two parts the greater holds.
    pub(crate) clearance_mm: f64,
    /// A rotation in which it stands in the volume.
    pub(crate) fitting: DQuat,
}

/// All items of an instance from outside; `None` for those that fit in no allowed orientation.
#[derive(Debug, Clone)]
pub(crate) struct Lineup {
    pub(crate) candidates: Vec<Option<Candidate>>,
    /// All copies that fit alone, in order of precedence.
    pub(crate) copies: Vec<(usize, u32)>,
    pub(crate) room: DVec3,
    /// The greatest clearance of any item, mm.
    pub(crate) reach_mm: f64,
    /// Where nothing may stand.
    pub(crate) zones: Vec<Zone>,
    /// Clearances also hold when either part is raised by up to this, mm.
    pub(crate) z_extra_mm: f64,
    /// Layers, and how much of one may be filled.
    pub(crate) cap: LayerCap,
}

impl Lineup {
    /// Looks at every item; `outlines` gives the outlines of meshes, in their order.
    pub(crate) fn new(instance: &Instance, outlines: impl Fn(&[Arc<Mesh>]) -> Vec<Arc<Outline>>) -> Self {
        let own = |item: &super::Item| item.clearance_mm.unwrap_or(0.0).max(instance.clearance_mm());
        let fitting = |item: &super::Item| fit::fits(&item.mesh, &item.orientation, &instance.volume()).ok();
        let fittings: Vec<Option<DQuat>> = instance.items().iter().map(fitting).collect();
        let standing =
            || instance.items().iter().zip(&fittings).filter_map(|(item, fitting)| Some((item, (*fitting)?)));
        let meshes: Vec<Arc<Mesh>> = standing().map(|(item, _)| item.mesh.clone()).collect();
        let mut outlines = outlines(&meshes).into_iter();
        let candidate = |(item, fitting): (&super::Item, &Option<DQuat>)| {
            Some(Candidate {
                fitting: (*fitting)?,
                mesh: item.mesh.clone(),
                outline: outlines.next()?,
                orientation: item.orientation.clone(),
                clearance_mm: own(item),
            })
        };
        let candidates: Vec<Option<Candidate>> = instance.items().iter().zip(&fittings).map(candidate).collect();
        let copies = (instance.items().iter().enumerate())
            .filter(|&(at, _)| candidates[at].is_some())
            .flat_map(|(at, item)| (0..item.copies).map(move |copy| (at, copy)))
            .collect();
        let reach_mm = instance.items().iter().map(own).fold(0.0, f64::max);
        let zones = instance.reserved().zones.clone();
        let z_extra_mm = instance.clearance_z_extra_mm();
        let (room, cap) = (instance.volume().size_mm, instance.layer_cap());
        Self { candidates, copies, room, reach_mm, z_extra_mm, zones, cap }
    }

    /// The item of a copy that is being nested.
    pub(crate) fn candidate(&self, item: usize) -> &Candidate {
        self.candidates[item].as_ref().expect("only items that fit are nested")
    }
}
