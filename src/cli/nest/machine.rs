//! What a build is nested for: a profile's machine, or one that the options describe.

use anyhow::Result;
use glam::DVec3;

use super::args::Args;
use crate::{
    cli::{Common, Usage},
    format::{Arrangement, Instances, Limits, Unit},
    geometry::Bounds,
    nest::{BuildVolume, Config, DEFAULT_LAYER_MM, LayerCap, Margins, NotDown, Orientation, OrientationRule, Tilt},
    settings::{self, KeepOut},
};

/// Clearance without a profile and without `--clearance`, mm.
const DEFAULT_CLEARANCE_MM: f64 = 3.0;

/// What the machine asks for: the profile's word unless an option says otherwise.
pub(super) struct Machine {
    pub(super) name: String,
    /// The printable box, mm.
    pub(super) volume_mm: DVec3,
    /// Boxes in which nothing may stand, in the machine's frame.
    pub(super) keep_out: Vec<Bounds>,
    pub(super) margins: Margins,
    pub(super) clearance_mm: f64,
    pub(super) clearance_z_extra_mm: f64,
    pub(super) layer_mm: f64,
    pub(super) layer_area_cap: Option<f64>,
    pub(super) orientation: Orientation,
    pub(super) unit: Unit,
    pub(super) limits: Limits,
    pub(super) config: Config,
    pub(super) instances: Instances,
    pub(super) arrangement: Arrangement,
}

impl Machine {
    /// Boxes in which nothing may stand, as the nester sees them.
    pub(super) fn keep_out_in_room(&self) -> Vec<Bounds> {
        let origin_mm = self.origin_mm();
        let moved = |zone: &Bounds| Bounds { min: zone.min - origin_mm, max: zone.max - origin_mm };
        self.keep_out.iter().map(moved).collect()
    }

    /// The box that may be filled.
    pub(super) fn room(&self) -> BuildVolume {
        self.margins.room(self.volume_mm)
    }

    /// Its layers, and how much of one may be filled.
    pub(super) fn layer_cap(&self) -> LayerCap {
        LayerCap::of_share(self.layer_mm, self.layer_area_cap, &self.room())
    }

    /// Where its corner stands in the machine's frame, mm.
    pub(super) fn origin_mm(&self) -> DVec3 {
        self.margins.origin_mm()
    }
}

/// The machine that the options ask for.
pub(super) fn machine(common: &Common, args: &Args) -> Result<Machine> {
    let mut machine = match &args.profile {
        Some(name) => from_profile(common, args, name)?,
        None => without_profile(args, args.volume.unwrap_or(DVec3::ZERO)),
    };
    machine.volume_mm = args.volume.unwrap_or(machine.volume_mm);
    machine.margins = args.margins.unwrap_or(machine.margins);
    machine.clearance_mm = args.clearance.unwrap_or(machine.clearance_mm);
    machine.layer_area_cap = args.layer_area_cap.or(machine.layer_area_cap);
    machine.clearance_z_extra_mm = args.clearance_z_extra.unwrap_or(machine.clearance_z_extra_mm);
    machine.config.method = args.method.unwrap_or(machine.config.method);
    machine.config.threads = args.threads.unwrap_or(machine.config.threads);
    machine.config.interlock = args.interlock.unwrap_or(machine.config.interlock);
    machine.config.seed = args.seed.unwrap_or(machine.config.seed);
    Ok(machine)
}

/// The machine's rules but for what an option says.
fn turning(args: &Args, rule: OrientationRule, keep_up: &[Tilt], not_down: &[NotDown]) -> Orientation {
    let keep_up = if args.keep_up.is_empty() { keep_up } else { &args.keep_up };
    let not_down = if args.not_down.is_empty() { not_down } else { &args.not_down };
    Orientation::new(args.orientation.unwrap_or(rule), keep_up, not_down)
}

fn without_profile(args: &Args, size_mm: DVec3) -> Machine {
    Machine {
        name: "none".to_owned(),
        volume_mm: size_mm,
        keep_out: Vec::new(),
        margins: Margins::default(),
        clearance_mm: DEFAULT_CLEARANCE_MM,
        clearance_z_extra_mm: 0.0,
        layer_mm: DEFAULT_LAYER_MM,
        layer_area_cap: None,
        orientation: turning(args, OrientationRule::default(), &[], &[]),
        unit: Unit::default(),
        limits: Limits::default(),
        config: Config::default(),
        instances: Instances::default(),
        arrangement: Arrangement::default(),
    }
}

fn from_profile(common: &Common, args: &Args, name: &str) -> Result<Machine> {
    let settings = settings::load(common.config.as_deref(), common.root.as_deref())
        .map_err(|error| Usage(format!("{:#}", anyhow::Error::from(error))))?;
    let known = || settings.profiles.keys().cloned().collect::<Vec<_>>().join(", ");
    let profile = (settings.profiles.get(name))
        .ok_or_else(|| Usage(format!("there is no profile {name}; there are: {}", known())))?;
    Ok(Machine {
        name: name.to_owned(),
        volume_mm: profile.volume_mm,
        keep_out: profile.keep_out.iter().map(KeepOut::bounds).collect(),
        margins: profile.margins(),
        clearance_mm: profile.clearance_mm,
        clearance_z_extra_mm: profile.clearance_z_extra_mm,
        layer_mm: profile.layer_mm,
        layer_area_cap: profile.layer_area_cap,
        orientation: turning(args, profile.orientation, &profile.keep_up, &profile.not_down),
        unit: profile.unit,
        limits: settings.limits.clone(),
        config: profile.nest.clone(),
        instances: profile.instances,
        arrangement: profile.arrangement,
    })
}
