//! What is asked of the nester, frozen: a build volume, a clearance and items with copies.

use std::sync::Arc;

use glam::DVec3;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{LayerCap, Orientation, reserved::Reserved};
use crate::geometry::Mesh;

/// Which rotations a part may have. A hard rule, checked again on the written file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum OrientationRule {
    /// Any rotation.
    #[default]
    Free,
    /// Rotations about z only: what was up stays up.
    Upright,
    /// The 24 rotations that map axes onto axes.
    Axis,
    /// As dropped; translations only.
    Fixed,
}

/// The printable box of a machine with its lower front left corner at the origin; wall margins are taken off already.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BuildVolume {
    /// Edge lengths, mm; z is the greatest build height.
    pub size_mm: DVec3,
}

/// What is kept free along the walls, above the floor and below the lid of a machine, mm.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Margins {
    /// Along the four walls.
    pub wall_mm: f64,
    /// Above the floor.
    pub floor_mm: f64,
    /// Below the lid.
    pub lid_mm: f64,
}

impl From<DVec3> for Margins {
    /// Wall, floor and lid in this order, mm.
    fn from(margins: DVec3) -> Self {
        Self { wall_mm: margins.x, floor_mm: margins.y, lid_mm: margins.z }
    }
}

impl Margins {
    /// The box that may be filled in a printable box, mm.
    pub fn room(&self, volume_mm: DVec3) -> BuildVolume {
        let taken = DVec3::new(2.0 * self.wall_mm, 2.0 * self.wall_mm, self.floor_mm + self.lid_mm);
        BuildVolume { size_mm: volume_mm - taken }
    }

    /// Wall, floor and lid in this order, mm.
    pub fn as_dvec3(self) -> DVec3 {
        DVec3::new(self.wall_mm, self.floor_mm, self.lid_mm)
    }

    /// Where the lower front left corner of the room stands in the machine's frame, mm.
    pub fn origin_mm(&self) -> DVec3 {
        DVec3::new(self.wall_mm, self.wall_mm, self.floor_mm)
    }
}

/// A part as the nester sees it.
#[derive(Debug, Clone)]
pub struct Item {
    /// Name for reports and proofs.
    pub name: String,
    /// The solid; equal meshes should be the same `Arc`, so that work on them is shared.
    pub mesh: Arc<Mesh>,
    /// How many copies to place, at least 1.
    pub copies: u32,
    /// How it may be turned.
    pub orientation: Orientation,
    /// Clearance of its own, mm; between two parts the greater clearance holds.
    pub clearance_mm: Option<f64>,
}

/// Why an instance makes no sense.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum InstanceError {
    /// A size is not a positive number.
    #[error("the build volume {0} x {1} x {2} mm is not a box")]
    BadVolume(f64, f64, f64),
    /// A clearance is negative or not a number.
    #[error("the clearance {0} mm is not a distance")]
    BadClearance(f64),
    /// A keep-out box is none.
    #[error("the keep-out from {0} to {1} mm is not a box")]
    BadKeepOut(DVec3, DVec3),
    /// A layer has no thickness, or none of it may be filled.
    #[error("at most {0} mm2 of layers of {1} mm is no cap")]
    BadLayers(f64, f64),
    /// There is nothing to nest.
    #[error("there is nothing to nest")]
    Empty,
}

/// What is asked. Items stand in order of precedence: where not all fit, earlier items come first.
#[derive(Debug, Clone)]
pub struct Instance {
    volume: BuildVolume,
    clearance_mm: f64,
    clearance_z_extra_mm: f64,
    layer_cap: LayerCap,
    items: Vec<Item>,
    reserved: Reserved,
}

impl Instance {
    /// Checks and freezes. Clearance in mm, items in order of precedence; items with 0 copies are allowed.
    pub fn new(volume: BuildVolume, clearance_mm: f64, items: Vec<Item>) -> Result<Self, InstanceError> {
        let size = volume.size_mm;
        if !(size.is_finite() && size.min_element() > 0.0) {
            return Err(InstanceError::BadVolume(size.x, size.y, size.z));
        }
        for clearance in items.iter().filter_map(|i| i.clearance_mm).chain([clearance_mm]) {
            if !(clearance.is_finite() && clearance >= 0.0) {
                return Err(InstanceError::BadClearance(clearance));
            }
        }
        if items.iter().all(|i| i.copies == 0) {
            return Err(InstanceError::Empty);
        }
        let (layer_cap, reserved) = (LayerCap::default(), Reserved::default());
        Ok(Self { volume, clearance_mm, clearance_z_extra_mm: 0.0, layer_cap, items, reserved })
    }

    pub(super) fn reserved(&self) -> &Reserved {
        &self.reserved
    }

    pub(super) fn reserved_mut(&mut self) -> &mut Reserved {
        &mut self.reserved
    }

    /// Asks for more clearance along z: between any two parts the clearance also holds when either of them is raised by
    /// anything from 0 to `extra_mm`.
    pub fn with_clearance_z_extra(self, extra_mm: f64) -> Result<Self, InstanceError> {
        if !(extra_mm.is_finite() && extra_mm >= 0.0) {
            return Err(InstanceError::BadClearance(extra_mm));
        }
        Ok(Self { clearance_z_extra_mm: extra_mm, ..self })
    }

    /// The box to fill.
    pub fn volume(&self) -> BuildVolume {
        self.volume
    }

    /// Least distance between the surfaces of two placements, mm.
    pub fn clearance_mm(&self) -> f64 {
        self.clearance_mm
    }

    /// Says how thick layers are, and how much of one may be filled.
    pub fn with_layer_cap(self, layer_cap: LayerCap) -> Result<Self, InstanceError> {
        if !(layer_cap.layer_mm.is_finite() && layer_cap.layer_mm > 0.0 && layer_cap.area_mm2 > 0.0) {
            return Err(InstanceError::BadLayers(layer_cap.area_mm2, layer_cap.layer_mm));
        }
        Ok(Self { layer_cap, ..self })
    }

    /// Layers, and how much of one may be filled.
    pub fn layer_cap(&self) -> LayerCap {
        self.layer_cap
    }

    /// By how much either of two parts may be raised without breaking their clearance, mm.
    pub fn clearance_z_extra_mm(&self) -> f64 {
        self.clearance_z_extra_mm
    }

    /// Items in order of precedence.
    pub fn items(&self) -> &[Item] {
        &self.items
    }

    /// The clearance that holds between two items, mm.
    pub fn clearance_between_mm(&self, item1: usize, item2: usize) -> f64 {
        let own = |item: usize| self.items[item].clearance_mm.unwrap_or(0.0);
        self.clearance_mm.max(own(item1)).max(own(item2))
    }

    /// Copies of all items.
    pub fn copies(&self) -> usize {
        self.items.iter().map(|i| i.copies as usize).sum()
    }
}
