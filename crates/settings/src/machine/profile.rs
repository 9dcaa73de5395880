//! One machine profile: its folders, its volume, its rules, and the triggers that fire its batches.

use std::path::{Path, PathBuf};

use build_file::LengthUnit;
use delivery::build::MachineSpec;
use glam::DVec3;
use intake::UnlistedPolicy;
use serde::{Deserialize, Serialize};

use crate::{CostRules, FarmZone, KeepOutZone, Materials, PrinterRules, PrintingRules};

/// The folders of a machine profile.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct MachineFolders {
    /// The hot folder, where parts are dropped.
    pub inbox: PathBuf,
    /// Finished build files, for the printer to take; of a machine with several printers, that of the first.
    pub queue: PathBuf,
    /// Refused files, each with its reason.
    pub error: PathBuf,
    /// Originals of published builds.
    pub archive: PathBuf,
}

/// What happens when an identical file is dropped again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DuplicatePolicy {
    /// The file is accepted as additional copies.
    Accept,
    /// The file is accepted as additional copies, with a warning on the part. One that a sync program may have put back waits for a
    /// person's yes.
    #[default]
    Warn,
    /// The file is refused.
    Refuse,
}

/// What happens to a mesh that is not closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MeshErrorPolicy {
    /// The file is refused.
    #[default]
    Refuse,
    /// The file is accepted, with a warning on the part.
    Warn,
    /// What can be mended is mended, with a warning on the part; the rest is refused.
    Repair,
}

/// When a batch is started ("fires"): as soon as one of these conditions holds. A batch always fires when it is full,
/// that is, when a waiting copy cannot be nested into it.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct TriggerRules {
    /// Fires when the open build's height reaches this share of the volume's height; `None` = off.
    pub fill_height: Option<f64>,
    /// Fires when the open build's density (part volume / whole build volume) reaches this share; `None` = off.
    pub fill_density: Option<f64>,
    /// Fires when this number of copies is waiting; `None` = off.
    pub copies: Option<u32>,
    /// Fires when the oldest part has waited for this time, seconds. A farm must never wait forever.
    pub max_wait_secs: f64,
    /// Fires when the time until a due date is less than the print time plus this margin, seconds; `None` = off.
    pub due_margin_secs: Option<f64>,
    /// Before it fires for a due date, no part may have arrived for this time, seconds; 0 = it fires at once.
    pub gather_secs: f64,
    /// Times of day at which the waiting parts fire, in the time zone of the farm.
    pub at: Vec<jiff::civil::Time>,
}

/// One machine profile, validated.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MachineProfile {
    /// Name; its folders have the same name.
    pub name: String,
    /// Its folders.
    pub folders: MachineFolders,
    /// Its printers, all alike; at least one.
    #[serde(skip)]
    pub printers: Vec<PrinterRules>,
    /// The time zone of the farm: of its due dates and times of day.
    #[serde(skip)]
    pub time_zone: FarmZone,
    /// What materials are called.
    #[serde(skip)]
    pub materials: Materials,
    /// Its file with the defaults of the farm, in TOML; "" = it was not read from a file.
    #[serde(skip)]
    pub text: String,
    /// The other node that serves it: its folders are there. "" = this one does, or nobody.
    #[serde(skip)]
    pub of_node: String,
    /// Its build space, and the distances between parts there.
    #[serde(flatten)]
    pub space: BuildSpace,
    /// The orientation rules of its parts.
    #[serde(flatten)]
    pub turning: TurningRules,
    /// The rules for taking files from the hot folder.
    #[serde(flatten)]
    pub intake: IntakeRules,
    /// When a batch is started.
    pub trigger: TriggerRules,
    /// The method and duration of the search.
    #[serde(flatten)]
    pub search: SearchRules,
    /// The rules for output files.
    #[serde(flatten)]
    pub output: OutputRules,
    /// The rules of its prints.
    #[serde(flatten)]
    pub printing: PrintingRules,
    /// What its builds cost.
    pub costs: CostRules,
}

/// The space that a machine builds in, with the rules for distances and layers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BuildSpace {
    /// Printable box of the machine, mm.
    pub volume_mm: DVec3,
    /// Margin kept free along the four walls, mm.
    pub wall_margin_mm: f64,
    /// Margin kept free above the floor, mm.
    pub floor_margin_mm: f64,
    /// Margin kept free below the top of the printable box, mm.
    pub lid_margin_mm: f64,
    /// Boxes in which no part may be placed, in the machine's frame.
    pub keep_out: Vec<KeepOutZone>,
    /// Minimum distance between two parts, mm.
    pub clearance_mm: f64,
    /// The clearance also holds if either of two parts is raised by up to this distance, mm.
    pub clearance_z_extra_mm: f64,
    /// Layer thickness, mm. Determines the number of layers of a build.
    pub layer_mm: f64,
    /// Maximum filled share of a layer, relative to the base of the build volume; `None` = off.
    pub layer_area_cap: Option<f64>,
    /// Hours that the machine needs per mm of build height, for due dates.
    pub print_hours_per_mm: f64,
}

/// Orientation rules of parts whose tickets do not contain any.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TurningRules {
    /// Orientation rule of parts without a ticket.
    pub orientation: nester::OrientationRule,
    /// Directions of the mesh that must point nearly straight up, for parts whose ticket names none.
    pub keep_up: Vec<nester::TiltLimit>,
    /// Faces, by their outward normals, that must not face down, for parts whose ticket names none.
    pub not_down: Vec<nester::FaceNotDown>,
}

/// When files are taken from the hot folder, and what happens to files with problems.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct IntakeRules {
    /// Unit of files that do not state one.
    pub unit: LengthUnit,
    /// Time that a file must be unchanged before it is taken, seconds.
    pub settle_secs: f64,
    /// Time after which an unchanged file that is incomplete (a stalled copy, an interrupted upload) is taken and
    /// refused with a reason, seconds.
    pub unfinished_secs: f64,
    /// Waiting time of a part that is not in the order list of its folder, and of an order list row without its file,
    /// seconds.
    pub incomplete_secs: f64,
    /// What happens to a part that is still not in the order list after that time.
    pub unlisted: UnlistedPolicy,
    /// Policy for identical files.
    pub duplicates: DuplicatePolicy,
    /// Policy for meshes that are not closed.
    pub mesh_errors: MeshErrorPolicy,
    /// A solid whose longest side is shorter waits for a person's yes, mm; 0 = never.
    pub min_size_mm: f64,
}

/// How the search works, how long it runs and how often it is tried.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SearchRules {
    /// Parameters of the nester.
    pub nest: nester::NestingConfig,
    /// Search time when a batch fires (the final budget), seconds.
    pub final_secs: f64,
    /// Search time for the open build after each new part, seconds.
    pub arrival_secs: f64,
    /// CPU time after that for lowering the layout of an open build that waits, since the last arrival, seconds; 0 = none.
    pub improve_secs: f64,
    /// Number of nesting attempts before the build fails.
    pub max_attempts: u32,
}

/// Which files are written for a build, and how long the originals are kept.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OutputRules {
    /// What builds are delivered as.
    pub delivery: build_file::DeliveryKind,
    /// Whether copies in a 3MF are separate build items or components of one object.
    pub arrangement: build_file::Arrangement,
    /// Whether to write the whole build also as one binary STL.
    pub stl_output: bool,
    /// Days that originals of published builds are kept; 0 = forever.
    pub archive_days: u32,
    /// Days that copies of published build files are kept; 0 = forever, `None` = no copies are made.
    pub archive_builds_days: Option<u32>,
}

impl MachineProfile {
    /// The box that may be filled: the printable box minus the margins.
    pub fn build_volume(&self) -> nester::BuildVolume {
        self.to_machine().build_volume()
    }

    /// The margins of the printable box.
    pub fn margins(&self) -> nester::VolumeMargins {
        nester::VolumeMargins {
            wall_mm: self.space.wall_margin_mm,
            floor_mm: self.space.floor_margin_mm,
            lid_mm: self.space.lid_margin_mm,
        }
    }

    /// The machine description used by builds.
    pub fn to_machine(&self) -> MachineSpec {
        MachineSpec {
            name: self.name.clone(),
            volume_mm: self.space.volume_mm,
            margins: self.margins(),
            keep_out: self.space.keep_out.iter().map(KeepOutZone::bounds).collect(),
            clearance_mm: self.space.clearance_mm,
            clearance_z_extra_mm: self.space.clearance_z_extra_mm,
            layer_cap: nester::LayerAreaCap::from_share(
                self.space.layer_mm,
                self.space.layer_area_cap,
                &self.margins().usable_volume(self.space.volume_mm),
            ),
            interlock: self.search.nest.effective_interlock(),
            delivery: self.output.delivery,
            arrangement: self.output.arrangement,
        }
    }

    /// Position of the lower front left corner of [`MachineProfile::build_volume`] in the machine's frame, mm.
    pub fn origin_mm(&self) -> DVec3 {
        self.to_machine().origin_mm()
    }
}

impl MachineProfile {
    /// The folders of this machine that are queues of its printers.
    pub fn queue_folders(&self) -> impl Iterator<Item = &Path> {
        self.printers.iter().filter_map(|printer| printer.queue.folder())
    }

    /// Whether its file names printers.
    pub fn has_named_printers(&self) -> bool {
        self.printers.len() > 1 || self.printers.iter().any(|printer| printer.name != self.name)
    }

    /// What messages call the queue folder of a printer.
    pub fn queue_description(&self, printer: &PrinterRules) -> String {
        match printer.name == self.name {
            true => format!("queue of {}", self.name),
            false => format!("queue of {}, printer {}", self.name, printer.name),
        }
    }

    /// The file of this name that is visible in the queue of one of its printers; where it is in none, its place in that of the printer
    /// that it was made for last, or else of the first.
    pub fn visible_file(&self, name: &str, printer: Option<&str>) -> PathBuf {
        let places = || self.printers.iter().map(|printer| printer.queue.visible_file(name));
        let of_its_printer =
            self.printers.iter().find(|one| Some(one.name.as_str()) == printer).or(self.printers.first());
        let its_place = || of_its_printer.map(|printer| printer.queue.visible_file(name));
        places().find(|file| file.exists()).or_else(its_place).unwrap_or_default()
    }
}

/// Whether a machine, or a printer, may have this name: its folders have it, too.
pub fn is_machine_name(name: &str) -> bool {
    let known = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    (1..=40).contains(&name.len()) && name.chars().all(known)
}
