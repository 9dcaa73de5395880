//! The machine that a build is for: its build volume, its keep-out boxes, and its rules for parts.

use std::sync::Arc;

use glam::DVec3;

use build_file::{Arrangement, InstanceSharing};
use nester::{
    BuildVolume, InstanceError, InterlockRule, LayerAreaCap, NestingInstance, NestingItem, PlacedSolid, VolumeMargins,
};
use solids::{Bounds, Mesh, Pose};

/// A machine as a build sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineSpec {
    /// Name of its profile.
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
    /// Whether all copies of a mesh share one object in the build file.
    pub instances: InstanceSharing,
    /// Whether the build file has build items or one object with components.
    pub arrangement: Arrangement,
}

impl MachineSpec {
    /// The box that may be filled: the printable box minus the margins.
    pub fn build_volume(&self) -> BuildVolume {
        self.margins.usable_volume(self.volume_mm)
    }

    /// The lower front left corner of [`MachineSpec::build_volume`] in the machine's frame, mm.
    pub fn origin_mm(&self) -> DVec3 {
        self.margins.origin_mm()
    }

    /// [`MachineSpec::keep_out`] in the frame of [`MachineSpec::build_volume`], mm.
    pub fn keep_out_in_volume(&self) -> Vec<Bounds> {
        let origin_mm = self.origin_mm();
        let moved = |zone: &Bounds| Bounds { min: zone.min - origin_mm, max: zone.max - origin_mm };
        self.keep_out.iter().map(moved).collect()
    }

    /// The instance for the nester.
    ///
    /// # Errors
    /// The nester rejects the values.
    pub fn create_instance(&self, items: Vec<NestingItem>) -> Result<NestingInstance, InstanceError> {
        NestingInstance::new(self.build_volume(), self.clearance_mm, items)?
            .with_clearance_z_extra(self.clearance_z_extra_mm)?
            .with_keep_out(&self.keep_out_in_volume())?
            .with_layer_cap(self.layer_cap)
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
