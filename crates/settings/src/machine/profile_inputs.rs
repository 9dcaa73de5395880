//! The second stage for machines: the values of a profile's file, merged with the farm's defaults. Only types are checked
//! here. Its options stand in one flat table of the file; here they are grouped as in
//! [`MachineProfile`](crate::MachineProfile).

use std::path::PathBuf;

use build_file::{Arrangement, DeliveryKind, LengthUnit};
use intake::UnlistedPolicy;
use nester::{FaceNotDown, NestingConfig, OrientationRule, TiltLimit};
use serde::{Deserialize, Deserializer, Serialize};

use super::printer::PrinterInputs;
use crate::{
    ApprovalPolicy, CostRules, DuplicatePolicy, KeepOutZone, MeshErrorPolicy, WithdrawalPolicy,
    reading::{
        duration::DurationSecs,
        option_group::{option_group, read_option_table, read_options},
        optional::OptionalValue,
    },
};

/// A profile's file; also `[defaults]` of the farm file.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub(crate) struct ProfileInputs {
    #[serde(flatten)]
    pub space: SpaceInputs,
    #[serde(flatten)]
    pub turning: TurningInputs,
    #[serde(flatten)]
    pub intake: IntakeInputs,
    #[serde(flatten)]
    pub search: SearchInputs,
    #[serde(flatten)]
    pub output: OutputInputs,
    #[serde(flatten)]
    pub printing: PrintingInputs,
    pub folders: ProfileFolders,
    pub trigger: TriggerInputs,
    pub delivery: DeliveryInputs,
    pub costs: CostRules,
    /// Only in the file of a machine.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub printer: Vec<PrinterInputs>,
}

read_options!(
    ProfileInputs: folders trigger delivery costs printer,
    groups space: SpaceInputs turning: TurningInputs intake: IntakeInputs search: SearchInputs output: OutputInputs
    printing: PrintingInputs
);

impl<'de> Deserialize<'de> for ProfileInputs {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        read_option_table(deserializer)
    }
}

option_group! {
    /// The printable box, and the distances between parts there.
    SpaceInputs {
        /// The only option without a default.
        #[serde(skip_serializing_if = "Option::is_none")]
        volume_mm: Option<[f64; 3]> = None,
        wall_margin_mm: f64 = 0.0,
        floor_margin_mm: f64 = 0.0,
        lid_margin_mm: f64 = 0.0,
        keep_out: Vec<KeepOutZone> = Vec::new(),
        clearance_mm: f64 = 3.0,
        clearance_z_extra_mm: f64 = 0.0,
        layer_mm: f64 = nester::DEFAULT_LAYER_MM,
        layer_area_cap: OptionalValue<f64> = OptionalValue::OFF,
        print_hours_per_mm: f64 = 0.1,
    }
}

option_group! {
    /// The orientation rules of parts whose tickets do not contain any.
    TurningInputs {
        orientation: OrientationRule = OrientationRule::default(),
        keep_up: Vec<TiltLimit> = Vec::new(),
        not_down: Vec<FaceNotDown> = Vec::new(),
    }
}

option_group! {
    /// When files are taken from the hot folder, and what happens to files with problems.
    IntakeInputs {
        unit: LengthUnit = LengthUnit::default(),
        settle_secs: DurationSecs = DurationSecs(5.0),
        unfinished_secs: DurationSecs = DurationSecs(120.0),
        incomplete_secs: DurationSecs = DurationSecs(600.0),
        unlisted: UnlistedPolicy = UnlistedPolicy::default(),
        duplicates: DuplicatePolicy = DuplicatePolicy::default(),
        mesh_errors: MeshErrorPolicy = MeshErrorPolicy::default(),
        min_size_mm: f64 = 1.0,
    }
}

option_group! {
    /// How the search works, how long it runs and how often it is tried.
    SearchInputs {
        final_secs: DurationSecs = DurationSecs(60.0),
        arrival_secs: DurationSecs = DurationSecs(20.0),
        improve_secs: DurationSecs = DurationSecs(3600.0),
        max_attempts: u32 = 3,
        nest: NestingConfig = NestingConfig::default(),
    }
}

option_group! {
    /// Which files are written for a build, and how long the originals are kept.
    OutputInputs {
        arrangement: Arrangement = Arrangement::default(),
        stl_output: bool = false,
        archive_days: u32 = 90,
        archive_builds_days: OptionalValue<u32> = OptionalValue::OFF,
    }
}

option_group! {
    /// How the printers are used.
    PrintingInputs {
        material: String = String::new(),
        cool_down_hours: f64 = 0.0,
        hours: String = "always".to_owned(),
        days_off: Vec<String> = Vec::new(),
        approve: ApprovalPolicy = ApprovalPolicy::default(),
        thin: f64 = 0.5,
        queue_depth: u32 = 0,
        withdraw: WithdrawalPolicy = WithdrawalPolicy::default(),
    }
}

/// `[folders]` of a profile's file: exact folders that replace those below the farm's folders.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct ProfileFolders {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inbox: Option<PathBuf>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub queue: Option<PathBuf>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<PathBuf>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub archive: Option<PathBuf>,
}

/// `[delivery]` of a profile. It is of the machine and not of a printer: its printers are alike, and a build that was made for one may go to
/// another one as it is.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct DeliveryInputs {
    pub kind: DeliveryKind,
}

/// `[trigger]` of a profile.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct TriggerInputs {
    pub fill_height: OptionalValue<f64>,
    pub fill_density: OptionalValue<f64>,
    pub copies: OptionalValue<u32>,
    pub max_wait_secs: DurationSecs,
    pub due_margin_secs: OptionalValue<DurationSecs>,
    pub gather_secs: DurationSecs,
    pub at: Vec<String>,
}

impl Default for TriggerInputs {
    fn default() -> Self {
        Self {
            fill_height: OptionalValue::OFF,
            fill_density: OptionalValue::OFF,
            copies: OptionalValue::OFF,
            max_wait_secs: DurationSecs(86_400.0),
            due_margin_secs: OptionalValue(Some(DurationSecs(3600.0))),
            gather_secs: DurationSecs(900.0),
            at: Vec::new(),
        }
    }
}
