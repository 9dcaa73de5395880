//! What a build is nested for: a profile's machine, or one that the options describe.

use anyhow::Result;
use build_file::{Arrangement, Instances, Limits, Unit};
use glam::DVec3;
use nester::{Config, LayerCap, Margins, NotDown, Orientation, OrientationRule, Tilt};

use super::args::Args;
use crate::{
    build::Machine,
    cli::{Common, Usage},
    settings,
};

/// Clearance without a profile and without `--clearance`, mm.
const DEFAULT_CLEARANCE_MM: f64 = 3.0;

/// What is asked for: the profile's word unless an option says otherwise.
pub(super) struct Setup {
    /// The machine.
    pub(super) machine: Machine,
    /// How the parts may be turned.
    pub(super) orientation: Orientation,
    /// Unit of files that do not say theirs.
    pub(super) unit: Unit,
    /// Limits of the readers.
    pub(super) limits: Limits,
    /// Search parameters.
    pub(super) config: Config,
}

/// The setup that the options ask for.
pub(super) fn setup(common: &Common, args: &Args) -> Result<Setup> {
    let (mut setup, layer_area_cap) = match &args.machine.profile {
        Some(name) => from_profile(common, args, name)?,
        None => (without_profile(args), None),
    };
    let (machine, config) = (&mut setup.machine, &mut setup.config);
    config.method = args.search.method.unwrap_or(config.method);
    config.threads = args.search.threads.unwrap_or(config.threads);
    config.interlock = args.turning.interlock.unwrap_or(config.interlock);
    config.seed = args.search.seed.unwrap_or(config.seed);
    machine.volume_mm = args.machine.volume.unwrap_or(machine.volume_mm);
    machine.margins = args.machine.margins.unwrap_or(machine.margins);
    machine.clearance_mm = args.machine.clearance.unwrap_or(machine.clearance_mm);
    machine.clearance_z_extra_mm = args.machine.clearance_z_extra.unwrap_or(machine.clearance_z_extra_mm);
    machine.interlock = config.interlock();
    let layer_area_cap = args.machine.layer_area_cap.or(layer_area_cap);
    machine.layer_cap = LayerCap::of_share(machine.layer_cap.layer_mm, layer_area_cap, &machine.build_volume());
    Ok(setup)
}

/// The machine's rules but for what an option says.
fn turning(args: &Args, rule: OrientationRule, keep_up: &[Tilt], not_down: &[NotDown]) -> Orientation {
    let keep_up = if args.turning.keep_up.is_empty() { keep_up } else { &args.turning.keep_up };
    let not_down = if args.turning.not_down.is_empty() { not_down } else { &args.turning.not_down };
    Orientation::new(args.turning.orientation.unwrap_or(rule), keep_up, not_down)
}

fn without_profile(args: &Args) -> Setup {
    let config = Config::default();
    let machine = Machine {
        name: "none".to_owned(),
        volume_mm: args.machine.volume.unwrap_or(DVec3::ZERO),
        margins: Margins::default(),
        keep_out: Vec::new(),
        clearance_mm: DEFAULT_CLEARANCE_MM,
        clearance_z_extra_mm: 0.0,
        layer_cap: LayerCap::default(),
        interlock: config.interlock(),
        instances: Instances::default(),
        arrangement: Arrangement::default(),
    };
    let orientation = turning(args, OrientationRule::default(), &[], &[]);
    Setup { machine, orientation, unit: Unit::default(), limits: Limits::default(), config }
}

/// What a profile asks for, and the share of a layer that it lets be filled.
fn from_profile(common: &Common, args: &Args, name: &str) -> Result<(Setup, Option<f64>)> {
    let settings = settings::load(common.config.as_deref(), common.root.as_deref())
        .map_err(|error| Usage(format!("{:#}", anyhow::Error::from(error))))?;
    let known = || settings.profiles.keys().cloned().collect::<Vec<_>>().join(", ");
    let profile = (settings.profiles.get(name))
        .ok_or_else(|| Usage(format!("there is no profile {name}; there are: {}", known())))?;
    let setup = Setup {
        machine: profile.machine(),
        orientation: turning(args, profile.turning.orientation, &profile.turning.keep_up, &profile.turning.not_down),
        unit: profile.intake.unit,
        limits: settings.limits.clone(),
        config: profile.search.nest.clone(),
    };
    Ok((setup, profile.space.layer_area_cap))
}
