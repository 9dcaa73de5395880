//! One machine: its folders, its volume, its rules and when its batches fire.

use std::path::PathBuf;

use build_file::Unit;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::KeepOut;
use crate::{build::Machine, intake::Unlisted};

/// Where a profile's files live.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Folders {
    /// Parts are dropped here.
    pub inbox: PathBuf,
    /// Finished build files, for the printer to take.
    pub queue: PathBuf,
    /// Refused files beside their reasons.
    pub error: PathBuf,
    /// Originals of published builds.
    pub archive: PathBuf,
}

/// What to do with an identical file that is dropped again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Duplicates {
    /// More copies.
    Accept,
    /// More copies, with a warning on the part.
    #[default]
    Warn,
    /// Refused.
    Reject,
}

/// What to do with a mesh that is not closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MeshErrors {
    /// Refused.
    #[default]
    Reject,
    /// Taken, with a warning on the part.
    Warn,
}

/// When a batch fires; the first that holds fires. "Full" (a waiting copy cannot be nested) always fires.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Trigger {
    /// Fires when the open build's height reaches this share of the volume's height; `None` = off.
    pub fill_height: Option<f64>,
    /// Fires when the open build's density (part volume / whole build volume) reaches this share; `None` = off.
    pub fill_density: Option<f64>,
    /// Fires when so many copies wait; `None` = off.
    pub copies: Option<u32>,
    /// Fires when the oldest part has waited so long, seconds. A farm must never wait for ever.
    pub max_wait_secs: f64,
    /// Fires when a due date is nearer than print time and this margin, seconds; `None` = off.
    pub due_margin_secs: Option<f64>,
    /// Times of day at which waiting parts fire, local time.
    pub at: Vec<jiff::civil::Time>,
}

/// One machine profile, validated.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Profile {
    /// Its name; also the names of its folders.
    pub name: String,
    /// Where its files live.
    pub folders: Folders,
    /// The space that it builds in.
    #[serde(flatten)]
    pub space: BuildSpace,
    /// How parts may be turned.
    #[serde(flatten)]
    pub turning: TurningRules,
    /// When files are taken.
    #[serde(flatten)]
    pub intake: IntakeRules,
    /// When a batch fires.
    pub trigger: Trigger,
    /// How long is searched.
    #[serde(flatten)]
    pub search: SearchRules,
    /// What is written.
    #[serde(flatten)]
    pub output: OutputRules,
}

/// The space that a machine builds in, and what holds between parts there.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BuildSpace {
    /// Printable box of the machine, mm.
    pub volume_mm: DVec3,
    /// Kept free along the four walls, mm.
    pub wall_margin_mm: f64,
    /// Kept free above the floor, mm.
    pub floor_margin_mm: f64,
    /// Kept free below the lid, mm.
    pub lid_margin_mm: f64,
    /// Boxes in which nothing may stand, in the machine's frame.
    pub keep_out: Vec<KeepOut>,
    /// Least distance between two parts, mm.
    pub clearance_mm: f64,
    /// The clearance also holds when either of two parts is raised by up to this, mm.
    pub clearance_z_extra_mm: f64,
    /// Layer thickness, mm; gives the number of layers of a build.
    pub layer_mm: f64,
    /// No layer may be filled beyond this share of the base of the build volume; `None` = off.
    pub layer_area_cap: Option<f64>,
    /// Hours that a machine needs per mm of build height, for due dates.
    pub print_hours_per_mm: f64,
}

/// How parts whose tickets say nothing may be turned.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TurningRules {
    /// Orientation rule of parts without a ticket.
    pub orientation: nester::OrientationRule,
    /// Directions of the mesh that must stand near to straight up, of parts whose ticket names none.
    pub keep_up: Vec<nester::Tilt>,
    /// Faces, by their outward normals, that must not look down, of parts whose ticket names none.
    pub not_down: Vec<nester::NotDown>,
}

/// When files are taken, and what becomes of odd ones.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct IntakeRules {
    /// Unit of files that do not say theirs.
    pub unit: Unit,
    /// A file must stand still so long before it is taken, seconds.
    pub settle_secs: f64,
    /// A file whose end is missing (a copy that stalled, a torn upload) is taken, to be refused with a reason, after it
    /// stood still so long, seconds.
    pub unfinished_secs: f64,
    /// A part that the order list beside it does not name, and a row without its file, wait so long, seconds.
    pub incomplete_secs: f64,
    /// What then becomes of the part.
    pub unlisted: Unlisted,
    /// What to do with identical files.
    pub duplicates: Duplicates,
    /// What to do with meshes that are not closed.
    pub mesh_errors: MeshErrors,
}

/// How long and how often is searched.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SearchRules {
    /// Search parameters.
    pub nest: nester::Config,
    /// Seconds of search when a batch fires (the final budget).
    pub final_secs: f64,
    /// Seconds of search that each arrival gives the open build.
    pub arrival_secs: f64,
    /// How often a failed nesting is tried again before the build fails.
    pub max_attempts: u32,
}

/// What is written of a build, and how long it is kept.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OutputRules {
    /// One object for all copies of a mesh, or one each.
    pub instances: build_file::Instances,
    /// Build items, or one object of components.
    pub arrangement: build_file::Arrangement,
    /// Also write the whole build as one binary STL.
    pub stl_output: bool,
    /// Originals of published builds are kept so many days; 0 = for ever.
    pub archive_days: u32,
}

impl Profile {
    /// The box that may be filled: the printable box less the margins.
    pub fn build_volume(&self) -> nester::BuildVolume {
        self.margins().room(self.space.volume_mm)
    }

    /// What is kept free of the printable box.
    pub fn margins(&self) -> nester::Margins {
        nester::Margins {
            wall_mm: self.space.wall_margin_mm,
            floor_mm: self.space.floor_margin_mm,
            lid_mm: self.space.lid_margin_mm,
        }
    }

    /// The machine as a build sees it.
    pub fn machine(&self) -> Machine {
        Machine {
            name: self.name.clone(),
            volume_mm: self.space.volume_mm,
            margins: self.margins(),
            keep_out: self.space.keep_out.iter().map(KeepOut::bounds).collect(),
            clearance_mm: self.space.clearance_mm,
            clearance_z_extra_mm: self.space.clearance_z_extra_mm,
            layer_cap: nester::LayerCap::of_share(self.space.layer_mm, self.space.layer_area_cap, &self.build_volume()),
            interlock: self.search.nest.interlock(),
            instances: self.output.instances,
            arrangement: self.output.arrangement,
        }
    }

    /// Where the lower front left corner of [`Profile::build_volume`] stands in the machine's frame, mm.
    pub fn origin_mm(&self) -> DVec3 {
        self.margins().origin_mm()
    }
}
