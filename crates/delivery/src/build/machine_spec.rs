//! The machine that a build is for: its build volume, its keep-out boxes, and its rules for parts.

use std::sync::Arc;

use glam::DVec3;

use build_file::{Arrangement, DeliveryKind};
use nester::{
    BuildVolume, InstanceError, InterlockRule, LayerAreaCap, NestingInstance, NestingItem, PlacedSolid, VolumeMargins,
};
use solids::{Bounds, Mesh, Pose};

/// Share of the cap of a layer that is filled where rounding may add to a layer.
const ROUNDED_LAYER: f64 = 0.9999;

/// A machine as a build sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineSpec {
    /// Its name.
    pub name: String,
    /// The printable box, mm.
    pub volume_mm: DVec3,
    /// Margins along the walls, above the floor and below the ceiling.
    pub margins: VolumeMargins,
    /// Boxes in which no part may be placed, in the machine's frame, mm.
    pub keep_out: Vec<Bounds>,
    /// Minimum distance between two parts, mm.
    pub clearance_mm: f64,
    /// The clearance must also hold when one of two parts is raised by up to this, mm.
    pub clearance_z_extra_mm: f64,
    /// Layer thickness, and how much area of one layer may be filled.
    pub layer_cap: LayerAreaCap,
    /// Whether parts may be locked into each other.
    pub interlock: InterlockRule,
    /// What builds are delivered as.
    pub delivery: DeliveryKind,
    /// Whether a 3MF has build items or one object with components.
    pub arrangement: Arrangement,
}

impl MachineSpec {
    /// The box that may be filled: the printable box minus the margins, and minus what rounding may move a part.
    pub fn build_volume(&self) -> BuildVolume {
        self.effective_margins().usable_volume(self.volume_mm)
    }

    /// What a layout needs beside the distances that are proved, so that it keeps them as it is written, mm.
    fn rounding_mm(&self) -> f64 {
        self.delivery.rounding_mm(self.volume_mm)
    }

    /// The same machine with exactly the distances that are proved of a written build.
    pub(super) fn as_proved(&self) -> Self {
        Self { delivery: DeliveryKind::default(), ..self.clone() }
    }

    fn effective_margins(&self) -> VolumeMargins {
        let (VolumeMargins { wall_mm, floor_mm, lid_mm }, rounding_mm) = (self.margins, self.rounding_mm());
        VolumeMargins { wall_mm: wall_mm + rounding_mm, floor_mm: floor_mm + rounding_mm, lid_mm: lid_mm + rounding_mm }
    }

    /// The lower front left corner of [`MachineSpec::build_volume`] in the machine's frame, mm.
    pub fn origin_mm(&self) -> DVec3 {
        self.effective_margins().origin_mm()
    }

    /// [`MachineSpec::keep_out`] in the frame of [`MachineSpec::build_volume`], mm.
    pub fn keep_out_in_volume(&self) -> Vec<Bounds> {
        let origin_mm = self.origin_mm();
        let moved = |zone: &Bounds| Bounds { min: zone.min - origin_mm, max: zone.max - origin_mm };
        self.keep_out.iter().map(moved).collect()
    }

    /// Why a build that was proved for `was`, and whose top is at `top_mm` above the machine's floor, is not proved for this machine: its
    /// space is smaller, or its rules are stricter. `None` = the proof holds.
    pub fn find_stricter_than(&self, was: &Self, top_mm: Option<f64>) -> Option<String> {
        if self.rounding_mm() > was.rounding_mm() {
            return Some(format!("{:.4} mm more are kept free for the rounding of an STL", self.rounding_mm()));
        }
        let ends_at = |machine: &Self| machine.origin_mm() + machine.build_volume().size_mm;
        let (begins, ends, mut ended) = (self.origin_mm(), ends_at(self), ends_at(was));
        // What lies below the ceiling does not depend on it.
        ended.z = top_mm.unwrap_or(ended.z).min(ended.z);
        if begins.cmpgt(was.origin_mm()).any() {
            return Some(format!("the space that may be filled begins at {}, {}, {} mm", begins.x, begins.y, begins.z));
        }
        if ends.cmplt(ended).any() {
            return Some(format!("the space that may be filled ends at {} x {} x {} mm", ends.x, ends.y, ends.z));
        }
        let is_kept_free = |zone: &Bounds| was.keep_out.iter().any(|free| free.contains_bounds(zone, 0.0));
        if let Some(Bounds { min, max }) = self.keep_out.iter().find(|zone| !is_kept_free(zone)) {
            let corner = |at: &DVec3| format!("{}, {}, {}", at.x, at.y, at.z);
            return Some(format!("no part may be placed between {} and {} mm", corner(min), corner(max)));
        }
        if self.clearance_mm > was.clearance_mm {
            return Some(format!("parts are to be {} mm apart", self.clearance_mm));
        }
        if self.clearance_z_extra_mm > was.clearance_z_extra_mm {
            return Some(format!("parts are to be apart when one is raised by up to {} mm", self.clearance_z_extra_mm));
        }
        let has_cap = self.layer_cap.cap_mm2().is_some();
        if has_cap
            && (self.layer_cap.area_mm2 < was.layer_cap.area_mm2 || self.layer_cap.layer_mm != was.layer_cap.layer_mm)
        {
            return Some("less of a layer may be filled".to_owned());
        }
        (self.interlock == InterlockRule::Forbid && was.interlock != InterlockRule::Forbid)
            .then(|| "parts must not be locked into each other".to_owned())
    }

    /// The instance for the nester.
    ///
    /// # Errors
    /// The nester refuses the values.
    pub fn create_instance(&self, mut items: Vec<NestingItem>) -> Result<NestingInstance, InstanceError> {
        let rounding_mm = self.rounding_mm();
        items.iter_mut().for_each(|item| item.clearance_mm = item.clearance_mm.map(|own_mm| own_mm + rounding_mm));
        let grown = |zone: Bounds| Bounds { min: zone.min - rounding_mm, max: zone.max + rounding_mm };
        let keep_out: Vec<Bounds> = self.keep_out_in_volume().into_iter().map(grown).collect();
        let mut layer_cap = self.layer_cap;
        if rounding_mm > 0.0 {
            layer_cap.area_mm2 *= ROUNDED_LAYER;
        }
        NestingInstance::new(self.build_volume(), self.clearance_mm + rounding_mm, items)?
            .with_clearance_z_extra(self.clearance_z_extra_mm)?
            .with_keep_out(&keep_out)?
            .with_layer_cap(layer_cap)
    }

    /// Converts a pose from the build volume's frame to the machine's frame.
    pub fn machine_pose(&self, pose: &Pose) -> Pose {
        Pose { rotation: pose.rotation, translation: pose.translation + self.origin_mm() }
    }

    /// Converts a pose from the machine's frame to the build volume's frame.
    pub fn volume_pose(&self, pose: &Pose) -> Pose {
        Pose { rotation: pose.rotation, translation: pose.translation - self.origin_mm() }
    }

    /// A body for the proof, from a mesh at a pose in the machine's frame. The larger of the part's and the machine's
    /// clearance counts.
    pub fn placed_body(&self, name: String, mesh: Arc<Mesh>, pose: &Pose, clearance_mm: Option<f64>) -> PlacedSolid {
        let clearance_mm = clearance_mm.unwrap_or(0.0).max(self.clearance_mm);
        PlacedSolid { name, mesh, pose: self.volume_pose(pose), clearance_mm }
    }
}
