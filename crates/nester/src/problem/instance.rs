//! The input of the nester: a build volume, a clearance, and items with copies. It does not change during the search.

use std::sync::Arc;

use glam::DVec3;
use solids::{Bounds, Mesh};
use thiserror::Error;

use super::reserved::{ReservedSpace, ReservedZone, box_mesh};
use crate::{BuildVolume, ItemPlacement, LayerAreaCap, OrientationLimits};

/// A zone is ignored if its part inside the volume is thinner than this, mm.
const THINNEST_MM: f64 = 1e-6;

/// A part to nest.
#[derive(Debug, Clone)]
pub struct NestingItem {
    /// Name for reports and proofs.
    pub name: String,
    /// The solid. Equal meshes should share one `Arc`, so that their preparation is shared.
    pub mesh: Arc<Mesh>,
    /// How many copies to place, at least 1.
    pub copies: u32,
    /// Allowed orientations.
    pub orientation: OrientationLimits,
    /// Clearance of this item, mm. Between two items the greater clearance applies.
    pub clearance_mm: Option<f64>,
}

impl NestingItem {
    /// Creates an item with this number of copies, any orientation, and the clearance of the instance.
    pub fn new(name: impl Into<String>, mesh: Arc<Mesh>, copies: u32) -> Self {
        Self { name: name.into(), mesh, copies, orientation: OrientationLimits::default(), clearance_mm: None }
    }

    /// The same item with limits on its orientation.
    #[must_use]
    pub fn with_orientation(self, orientation: impl Into<OrientationLimits>) -> Self {
        Self { orientation: orientation.into(), ..self }
    }

    /// The same item with its own clearance, mm.
    #[must_use]
    pub fn with_clearance(self, clearance_mm: f64) -> Self {
        Self { clearance_mm: Some(clearance_mm), ..self }
    }
}

/// Why an instance is invalid.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum InstanceError {
    /// A size is not a positive number.
    #[error("the build volume {0} x {1} x {2} mm is not a box")]
    BadVolume(f64, f64, f64),
    /// A clearance is negative or not a number.
    #[error("the clearance {0} mm is not a distance")]
    BadClearance(f64),
    /// A keep-out box is not a valid box.
    #[error("the keep-out from {0} to {1} mm is not a box")]
    BadKeepOut(DVec3, DVec3),
    /// The layer thickness or the area cap is not positive.
    #[error("{0} mm2 is not a valid area cap for layers of {1} mm")]
    BadLayers(f64, f64),
    /// No item has any copies.
    #[error("there is nothing to nest")]
    Empty,
    /// A serialized item refers to a mesh that does not exist.
    #[error("item {item} names mesh {mesh}, but there are only {meshes}")]
    NoMesh {
        /// Index of the item.
        item: usize,
        /// The mesh index in the item.
        mesh: usize,
        /// Number of meshes.
        meshes: usize,
    },
}

/// The nesting problem. Items are in order of precedence: if not all copies fit, a copy is left out only if it found
/// no place beside the placed copies of earlier items and of its own. (Boxes that are stacked because the budget is
/// spent at once, and the published method, keep to the order only roughly.)
///
/// ```
/// use std::sync::Arc;
/// use glam::DVec3;
/// use nester::{BuildVolume, NestingInstance, InstanceError, NestingItem, OrientationRule};
/// use solids::Mesh;
///
/// let volume = BuildVolume { size_mm: DVec3::new(200.0, 200.0, 300.0) };
/// let pulley = NestingItem::new("pulley", Arc::new(Mesh::tube(44.0, 8.0, 12.0)?), 6);
/// let knob = NestingItem::new("knob", Arc::new(Mesh::tube(42.0, 20.0, 20.0)?), 4).with_orientation(OrientationRule::Upright);
/// let instance = NestingInstance::new(volume, 3.0, vec![pulley, knob.with_clearance(5.0)])?;
/// assert_eq!((instance.copy_count(), instance.clearance_between_mm(0, 1)), (10, 5.0));
///
/// assert_eq!(NestingInstance::new(volume, 3.0, Vec::new()).unwrap_err(), InstanceError::Empty);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// serde writes every distinct mesh (`Arc`) once. An instance that is read passes the same checks as in
/// [`NestingInstance::new`].
#[derive(Debug, Clone)]
pub struct NestingInstance {
    volume: BuildVolume,
    clearance_mm: f64,
    clearance_z_extra_mm: f64,
    layer_cap: LayerAreaCap,
    items: Vec<NestingItem>,
    reserved: ReservedSpace,
}

impl NestingInstance {
    /// Checks the input. The clearance is in mm; items are in order of precedence; items with 0 copies are allowed.
    pub fn new(volume: BuildVolume, clearance_mm: f64, items: Vec<NestingItem>) -> Result<Self, InstanceError> {
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
        let (layer_cap, reserved) = (LayerAreaCap::default(), ReservedSpace::default());
        Ok(Self { volume, clearance_mm, clearance_z_extra_mm: 0.0, layer_cap, items, reserved })
    }

    pub(crate) fn reserved_space(&self) -> &ReservedSpace {
        &self.reserved
    }

    /// Keeps boxes of the build volume free, mm in its frame. No part may touch such a box, but no clearance to it is
    /// required. The part of a box outside the volume is ignored.
    ///
    /// ```
    /// # use std::sync::Arc;
    /// use glam::DVec3;
    /// use nester::{BuildVolume, NestingInstance, NestingItem};
    /// use solids::{Bounds, Mesh};
    ///
    /// # let cube = Arc::new(Mesh::cuboid(DVec3::splat(10.0))?);
    /// # let instance = NestingInstance::new(BuildVolume { size_mm: DVec3::splat(50.0) }, 1.0, vec![NestingItem::new("cube", cube, 3)])?;
    /// let sensor = Bounds { min: DVec3::new(-9.0, 0.0, 0.0), max: DVec3::new(8.0, 8.0, 50.0) };
    /// let instance = instance.with_keep_out(&[sensor])?;
    /// assert_eq!(instance.keep_out()[0].min.x, 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_keep_out(mut self, boxes: &[Bounds]) -> Result<Self, InstanceError> {
        let room = Bounds { min: DVec3::ZERO, max: self.volume.size_mm };
        let mut zones = Vec::new();
        for keep_out in boxes {
            let is_box = keep_out.min.is_finite() && keep_out.max.is_finite() && keep_out.min.cmplt(keep_out.max).all();
            let inside = Bounds { min: keep_out.min.max(room.min), max: keep_out.max.min(room.max) };
            let solid = if is_box { Ok(()) } else { Err(InstanceError::BadKeepOut(keep_out.min, keep_out.max)) };
            solid?;
            if inside.size().min_element() > THINNEST_MM {
                let mesh = box_mesh(&inside).ok_or(InstanceError::BadKeepOut(keep_out.min, keep_out.max))?;
                zones.push(ReservedZone { bounds: inside, mesh: Arc::new(mesh) });
            }
        }
        self.reserved.zones = zones;
        Ok(self)
    }

    /// Fixes copies at given poses: they are part of every layout and never move. If a pose breaks a rule, or is too
    /// close to an earlier fixed copy, that copy remains unplaced.
    ///
    /// ```
    /// # use std::sync::Arc;
    /// use glam::{DQuat, DVec3};
    /// use nester::{BuildVolume, NestingConfig, NestingInstance, NestingItem, ItemPlacement, SearchBudget, nest};
    /// use solids::{Mesh, Pose};
    ///
    /// # let cube = Arc::new(Mesh::cuboid(DVec3::splat(10.0))?);
    /// # let instance = NestingInstance::new(BuildVolume { size_mm: DVec3::splat(50.0) }, 1.0, vec![NestingItem::new("cube", cube, 3)])?;
    /// let labelled = ItemPlacement { item: 0, copy: 1, pose: Pose::new(DQuat::IDENTITY, DVec3::new(20.0, 20.0, 5.0)) };
    /// let instance = instance.with_pinned(vec![labelled]);
    /// let solution = nest(&instance, &NestingConfig::default(), &[], &SearchBudget::of_evaluations(300), &mut ());
    /// assert_eq!(solution.placements[1], labelled);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn with_pinned(mut self, pinned: Vec<ItemPlacement>) -> Self {
        self.reserved.pinned = pinned;
        self
    }

    /// The parts of the keep-out boxes that lie inside the volume, mm.
    pub fn keep_out(&self) -> Vec<Bounds> {
        self.reserved.zones.iter().map(|zone| zone.bounds).collect()
    }

    /// The copies with fixed poses.
    pub fn pinned(&self) -> &[ItemPlacement] {
        &self.reserved.pinned
    }

    /// Requires more clearance along z: the clearance between any two parts must also hold if either of them is
    /// raised by any distance from 0 to `extra_mm`.
    pub fn with_clearance_z_extra(self, extra_mm: f64) -> Result<Self, InstanceError> {
        if !(extra_mm.is_finite() && extra_mm >= 0.0) {
            return Err(InstanceError::BadClearance(extra_mm));
        }
        Ok(Self { clearance_z_extra_mm: extra_mm, ..self })
    }

    /// The build volume.
    pub fn volume(&self) -> BuildVolume {
        self.volume
    }

    /// Minimum distance between the surfaces of two placements, mm.
    pub fn clearance_mm(&self) -> f64 {
        self.clearance_mm
    }

    /// Sets the layer thickness and the maximum filled area of a layer.
    pub fn with_layer_cap(self, layer_cap: LayerAreaCap) -> Result<Self, InstanceError> {
        if !(layer_cap.layer_mm.is_finite() && layer_cap.layer_mm > 0.0 && layer_cap.area_mm2 > 0.0) {
            return Err(InstanceError::BadLayers(layer_cap.area_mm2, layer_cap.layer_mm));
        }
        Ok(Self { layer_cap, ..self })
    }

    /// The layer thickness and the maximum filled area of a layer.
    pub fn layer_cap(&self) -> LayerAreaCap {
        self.layer_cap
    }

    /// The height by which either of two parts may be raised without breaking their clearance, mm.
    pub fn clearance_z_extra_mm(&self) -> f64 {
        self.clearance_z_extra_mm
    }

    /// Items in order of precedence.
    pub fn items(&self) -> &[NestingItem] {
        &self.items
    }

    /// The clearance that applies between two items, mm.
    pub fn clearance_between_mm(&self, item1: usize, item2: usize) -> f64 {
        let own = |item: usize| self.items[item].clearance_mm.unwrap_or(0.0);
        self.clearance_mm.max(own(item1)).max(own(item2))
    }

    /// Number of copies of all items together.
    pub fn copy_count(&self) -> usize {
        self.items.iter().map(|i| i.copies as usize).sum()
    }
}
