//! What is asked of the nester, frozen: a build volume, a clearance and items with copies.

use std::sync::Arc;

use glam::DVec3;
use solids::{Bounds, Mesh};
use thiserror::Error;

use super::{
    BuildVolume, LayerCap, Orientation, Placement,
    reserved::{Reserved, Zone, block},
};

/// Slices of a zone thinner than this inside the volume keep nothing out, mm.
const THINNEST_MM: f64 = 1e-6;

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

    /// Keeps boxes of the build volume free, mm in its frame: nothing touches them, but nothing keeps a clearance from
    /// them either. What of a box lies outside the volume is of no matter.
    pub fn with_keep_out(mut self, boxes: &[Bounds]) -> Result<Self, InstanceError> {
        let room = Bounds { min: DVec3::ZERO, max: self.volume.size_mm };
        let mut zones = Vec::new();
        for keep_out in boxes {
            let is_box = keep_out.min.is_finite() && keep_out.max.is_finite() && keep_out.min.cmplt(keep_out.max).all();
            let inside = Bounds { min: keep_out.min.max(room.min), max: keep_out.max.min(room.max) };
            let solid = if is_box { Ok(()) } else { Err(InstanceError::BadKeepOut(keep_out.min, keep_out.max)) };
            solid?;
            if inside.size().min_element() > THINNEST_MM {
                let mesh = block(&inside).ok_or(InstanceError::BadKeepOut(keep_out.min, keep_out.max))?;
                zones.push(Zone { bounds: inside, mesh: Arc::new(mesh) });
            }
        }
        self.reserved.zones = zones;
        Ok(self)
    }

    /// Promises copies where they stand: they are part of every layout and never move. A copy whose pose breaks a rule, or
    /// comes too near to one promised before it, is placed nowhere rather than elsewhere.
    #[must_use]
    pub fn with_pinned(mut self, pinned: Vec<Placement>) -> Self {
        self.reserved.pinned = pinned;
        self
    }

    /// The boxes that are kept free, as far as they lie in the volume, mm.
    pub fn keep_out(&self) -> Vec<Bounds> {
        self.reserved.zones.iter().map(|zone| zone.bounds).collect()
    }

    /// The copies that never move.
    pub fn pinned(&self) -> &[Placement] {
        &self.reserved.pinned
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
