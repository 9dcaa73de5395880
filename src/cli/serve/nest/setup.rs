//! The setup of a search: the machine and rules of a profile, or those that the options describe.

use anyhow::Result;
use build_file::{Arrangement, DeliveryKind, LengthUnit, ReadLimits};
use delivery::build::MachineSpec;
use glam::DVec3;
use nester::{FaceNotDown, LayerAreaCap, NestingConfig, OrientationLimits, OrientationRule, TiltLimit, VolumeMargins};

use super::args::NestArgs;
use crate::cli::{CommonArgs, UsageError};

/// Clearance without a profile and without `--clearance`, mm.
const DEFAULT_CLEARANCE_MM: f64 = 3.0;

/// The values of the profile, overridden by the options.
pub(super) struct NestingSetup {
    /// The machine.
    pub(super) machine: MachineSpec,
    /// How the parts may be turned.
    pub(super) orientation: OrientationLimits,
    /// Unit of files that do not state their own.
    pub(super) unit: LengthUnit,
    /// Limits of the readers.
    pub(super) limits: ReadLimits,
    /// Search parameters.
    pub(super) config: NestingConfig,
}

/// Resolves the setup from the profile and the options.
pub(super) fn resolve_setup(common: &CommonArgs, args: &NestArgs) -> Result<NestingSetup> {
    let (mut setup, layer_area_cap) = match &args.machine.machine {
        Some(name) => setup_from_profile(common, args, name)?,
        None => (setup_without_profile(args), None),
    };
    let (machine, config) = (&mut setup.machine, &mut setup.config);
    config.method = args.search.method.unwrap_or(config.method);
    config.threads = args.search.threads.unwrap_or(config.threads);
    config.lanes = args.search.lanes.unwrap_or(config.lanes);
    config.interlock = args.turning.interlock.unwrap_or(config.interlock);
    config.seed = args.search.seed.unwrap_or(config.seed);
    machine.volume_mm = args.machine.volume.unwrap_or(machine.volume_mm);
    machine.margins = args.machine.margins.unwrap_or(machine.margins);
    machine.clearance_mm = args.machine.clearance.unwrap_or(machine.clearance_mm);
    machine.clearance_z_extra_mm = args.machine.clearance_z_extra.unwrap_or(machine.clearance_z_extra_mm);
    machine.interlock = config.effective_interlock();
    // What is written here is a 3MF, whatever the machine's builds are delivered as.
    machine.delivery = if machine.delivery.is_rounded() { DeliveryKind::default() } else { machine.delivery };
    let layer_area_cap = args.machine.layer_area_cap.or(layer_area_cap);
    machine.layer_cap = LayerAreaCap::from_share(machine.layer_cap.layer_mm, layer_area_cap, &machine.build_volume());
    Ok(setup)
}

/// The profile's orientation rules, overridden by the options.
fn orientation_rules(
    args: &NestArgs,
    rule: OrientationRule,
    keep_up: &[TiltLimit],
    not_down: &[FaceNotDown],
) -> OrientationLimits {
    let keep_up = if args.turning.keep_up.is_empty() { keep_up } else { &args.turning.keep_up };
    let not_down = if args.turning.not_down.is_empty() { not_down } else { &args.turning.not_down };
    OrientationLimits::new(args.turning.orientation.unwrap_or(rule), keep_up, not_down)
}

fn setup_without_profile(args: &NestArgs) -> NestingSetup {
    let config = NestingConfig::default();
    let machine = MachineSpec {
        name: "none".to_owned(),
        volume_mm: args.machine.volume.unwrap_or(DVec3::ZERO),
        margins: VolumeMargins::default(),
        keep_out: Vec::new(),
        clearance_mm: DEFAULT_CLEARANCE_MM,
        clearance_z_extra_mm: 0.0,
        layer_cap: LayerAreaCap::default(),
        interlock: config.effective_interlock(),
        delivery: DeliveryKind::default(),
        arrangement: Arrangement::default(),
    };
    let orientation = orientation_rules(args, OrientationRule::default(), &[], &[]);
    NestingSetup { machine, orientation, unit: LengthUnit::default(), limits: ReadLimits::default(), config }
}

/// The setup of a profile, and the largest share of a layer that the profile allows to fill.
fn setup_from_profile(common: &CommonArgs, args: &NestArgs, name: &str) -> Result<(NestingSetup, Option<f64>)> {
    let settings = settings::load_settings(common.config.as_deref(), common.root.as_deref())
        .map_err(|error| UsageError(format!("{:#}", anyhow::Error::from(error))))?;
    let known = || settings.profiles.keys().cloned().collect::<Vec<_>>().join(", ");
    let profile = (settings.profiles.get(name))
        .ok_or_else(|| UsageError(format!("there is no machine {name}; there are: {}", known())))?;
    let setup = NestingSetup {
        machine: profile.to_machine(),
        orientation: orientation_rules(
            args,
            profile.turning.orientation,
            &profile.turning.keep_up,
            &profile.turning.not_down,
        ),
        unit: profile.intake.unit,
        limits: settings.limits.clone(),
        config: profile.search.nest.clone(),
    };
    Ok((setup, profile.space.layer_area_cap))
}
