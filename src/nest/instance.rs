//! What is asked of the nester, frozen: a build volume, a clearance and items with copies.

use std::sync::Arc;

use glam::DVec3;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::reserved::Reserved;
use crate::geometry::Mesh;

/// How a part may be turned. A hard rule, checked again on the written file.
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
    pub orientation: OrientationRule,
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
    /// There is nothing to nest.
    #[error("there is nothing to nest")]
    Empty,
}

/// What is asked. Items stand in order of precedence: where not all fit, earlier items come first.
#[derive(Debug, Clone)]
pub struct Instance {
    volume: BuildVolume,
    clearance_mm: f64,
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
        Ok(Self { volume, clearance_mm, items, reserved: Reserved::default() })
    }

    pub(super) fn reserved(&self) -> &Reserved {
        &self.reserved
    }

    pub(super) fn reserved_mut(&mut self) -> &mut Reserved {
        &mut self.reserved
    }

    /// The box to fill.
    pub fn volume(&self) -> BuildVolume {
        self.volume
    }

    /// Least distance between the surfaces of two placements, mm.
    pub fn clearance_mm(&self) -> f64 {
        self.clearance_mm
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
