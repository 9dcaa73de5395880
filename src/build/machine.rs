//! The machine that a build is for: its box, what is kept free of it, and what holds between parts.

use std::sync::Arc;

use glam::DVec3;

use build_file::{Arrangement, Instances};
use nester::{Body, BuildVolume, Instance, InstanceError, Interlock, Item, LayerCap, Margins};
use solids::{Bounds, Mesh, Pose};

/// A machine as a build sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    /// Name of its profile.
    pub name: String,
    /// The printable box, mm.
    pub volume_mm: DVec3,
    /// What is kept free along its walls, above its floor and below its lid.
    pub margins: Margins,
    /// Boxes in which nothing may stand, in the machine's frame, mm.
    pub keep_out: Vec<Bounds>,
    /// Least distance between two parts, mm.
    pub clearance_mm: f64,
    /// The clearance also holds when either of two parts is raised by up to this, mm.
    pub clearance_z_extra_mm: f64,
    /// Its layers, and how much of one may be filled.
    pub layer_cap: LayerCap,
    /// What becomes of parts that are locked into each other.
    pub interlock: Interlock,
    /// One object for all copies of a mesh, or one each.
    pub instances: Instances,
    /// Build items, or one object of components.
    pub arrangement: Arrangement,
}

impl Machine {
    /// The box that may be filled: the printable box less the margins.
    pub fn build_volume(&self) -> BuildVolume {
        self.margins.room(self.volume_mm)
    }

    /// Where the lower front left corner of [`Machine::build_volume`] stands in the machine's frame, mm.
    pub fn origin_mm(&self) -> DVec3 {
        self.margins.origin_mm()
    }

    /// [`Machine::keep_out`] in the frame of [`Machine::build_volume`], mm.
    pub fn keep_out_in_volume(&self) -> Vec<Bounds> {
        let origin_mm = self.origin_mm();
        let moved = |zone: &Bounds| Bounds { min: zone.min - origin_mm, max: zone.max - origin_mm };
        self.keep_out.iter().map(moved).collect()
    }

    /// What the nester is asked.
    ///
    /// # Errors
    /// Whatever the nester objects to.
    pub fn instance(&self, items: Vec<Item>) -> Result<Instance, InstanceError> {
        Instance::new(self.build_volume(), self.clearance_mm, items)?
            .with_clearance_z_extra(self.clearance_z_extra_mm)?
            .with_keep_out(&self.keep_out_in_volume())?
            .with_layer_cap(self.layer_cap)
    }

    /// A pose of the build volume's frame in the machine's.
    pub fn machine_pose(&self, pose: &Pose) -> Pose {
        Pose { rotation: pose.rotation, translation: pose.translation + self.origin_mm() }
    }

    /// A pose of the machine's frame in the build volume's.
    pub fn volume_pose(&self, pose: &Pose) -> Pose {
        Pose { rotation: pose.rotation, translation: pose.translation - self.origin_mm() }
    }

    /// A mesh at a pose in the machine's frame, as it is judged; its own clearance counts where it is greater.
    pub fn body(&self, name: String, mesh: Arc<Mesh>, pose: &Pose, clearance_mm: Option<f64>) -> Body {
        let clearance_mm = clearance_mm.unwrap_or(0.0).max(self.clearance_mm);
        Body { name, mesh, pose: self.volume_pose(pose), clearance_mm }
    }
}
