//! `nestd verify`: reads a build file from any program and proves it on its triangles.

use std::{
    io::Write,
    path::{Path, PathBuf},
};

use anyhow::Result;
use build_file::{Arrangement, BuildMetadata, DeliveryKind, ReadLimits};
use delivery::build::{BuildFileVerification, MachineSpec};
use glam::DVec3;
use nester::{DEFAULT_LAYER_MM, InterlockRule, LayerAreaCap, VolumeMargins};
use serde_json::{Value, json};

use crate::cli::{
    CommandExit, CommonArgs, UsageError,
    terminal::{
        expected_parts,
        values::{parse_distance, parse_margins, parse_volume, parse_word},
    },
};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit code 0 proved, 1 not proved, 2 wrong use or not readable.")]
pub struct VerifyArgs {
    /// The build file; of one STL, the table of places lies beside it
    #[arg(value_name = "BUILD.3mf")]
    build: PathBuf,
    /// Build volume in mm, e.g. 380x284x380 [default: what the file says]
    #[arg(long, value_name = "XxYxZ", value_parser = parse_volume)]
    volume: Option<DVec3>,
    /// Least distance between two parts, mm [default: what the file says]
    #[arg(long, value_name = "MM", value_parser = parse_distance)]
    clearance: Option<f64>,
    /// Parts locked into each other: forbid (then the build is not proved), warn or allow (not checked) [default: what
    /// the file says, else warn]
    #[arg(long, value_name = "RULE", value_parser = parse_word::<InterlockRule>)]
    interlock: Option<InterlockRule>,
    /// The clearance also holds when either of two parts is raised by up to this, mm [default: what the file says, else 0]
    #[arg(long, value_name = "MM", value_parser = parse_distance)]
    clearance_z_extra: Option<f64>,
    /// Kept free, mm: all around, or at walls, floor and lid [default: what the file says, else 0]
    #[arg(long, value_name = "MM|WALL,FLOOR,LID", value_parser = parse_margins)]
    margins: Option<VolumeMargins>,
    /// Parts that the file must contain, with their copies: CSV with the columns file and copies (or quantity)
    #[arg(long, value_name = "PARTS.csv")]
    list: Option<PathBuf>,
    /// Folder that the list's files are relative to [default: the list's own]
    #[arg(long, value_name = "DIR", requires = "list")]
    base: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// The result of a verification.
struct VerificationResult {
    info: BuildMetadata,
    machine: MachineSpec,
    verdict: BuildFileVerification,
    /// Top of the highest placement above the machine's floor, mm.
    height_mm: f64,
    /// Parts of the list that are missing in the file, and parts in the file that are not in the list.
    list_faults: Vec<String>,
}

impl VerificationResult {
    fn is_proved(&self) -> bool {
        self.verdict.is_proved() && self.list_faults.is_empty()
    }

    /// The faults, a line each.
    fn fault_lines(&self) -> impl Iterator<Item = String> {
        self.verdict.fault_messages().into_iter().chain(self.list_faults.iter().cloned())
    }
}

/// Runs the command.
pub fn run(_common: &CommonArgs, args: &VerifyArgs) -> Result<CommandExit> {
    let verified = verify_build(args)?;
    let text = match args.json {
        true => format!("{:#}", as_json(&verified)),
        false => format!("{}: {}", args.build.display(), text_lines(&verified).join("\n  ")),
    };
    // A closed pipe (`| head`) is ignored, so that the exit code stays right.
    let _ = writeln!(std::io::stdout(), "{text}");
    Ok(if verified.is_proved() { CommandExit::Success } else { CommandExit::Failure })
}

fn verify_build(args: &VerifyArgs) -> Result<VerificationResult> {
    let limits = ReadLimits::default();
    let (info, placed) = build_file::read_build_and_metadata(&args.build, &limits)
        .map_err(|error| UsageError(format!("{}: {:#}", args.build.display(), anyhow::Error::from(error))))?;
    let machine = resolve_machine(args, &info)?;
    let list_faults = match &args.list {
        Some(list) => {
            let base = args.base.as_deref().or(list.parent()).unwrap_or(Path::new("."));
            expected_parts::find_list_faults(&expected_parts::read_expected_parts(list, base, &limits)?, &placed)
        }
        None => Vec::new(),
    };
    let verdict = BuildFileVerification::verify_file(&args.build, &info, &placed, &machine, &limits);
    let height_mm = verdict.placement_checks.proof.height_mm + machine.margins.floor_mm;
    Ok(VerificationResult { info, machine, verdict, height_mm, list_faults })
}

/// The machine that the file is for: the file's metadata, overridden by the options.
fn resolve_machine(args: &VerifyArgs, info: &BuildMetadata) -> Result<MachineSpec> {
    let missing = |what: &str| UsageError(format!("the file does not say its {what}: give --{what}"));
    let stored = || info.rules.interlock.as_deref().and_then(|stored| parse_word(stored).ok());
    let layer_mm = info.rules.layer_mm.filter(|mm| (0.001..=10.0).contains(mm)).unwrap_or(DEFAULT_LAYER_MM);
    Ok(MachineSpec {
        name: info.heading.machine.clone().unwrap_or_default(),
        volume_mm: args.volume.or(info.rules.volume_mm).ok_or_else(|| missing("volume"))?,
        margins: args.margins.or(info.rules.margins_mm.map(VolumeMargins::from)).unwrap_or_default(),
        keep_out: info.rules.keep_out.clone(),
        clearance_mm: args.clearance.or(info.rules.clearance_mm).ok_or_else(|| missing("clearance"))?,
        clearance_z_extra_mm: args.clearance_z_extra.or(info.rules.clearance_z_extra_mm).unwrap_or(0.0),
        layer_cap: LayerAreaCap { layer_mm, area_mm2: info.rules.layer_area_cap_mm2.unwrap_or(f64::INFINITY) },
        interlock: args.interlock.or_else(stored).unwrap_or(InterlockRule::Warn),
        delivery: DeliveryKind::default(),
        arrangement: Arrangement::default(),
    })
}

fn text_lines(verified: &VerificationResult) -> Vec<String> {
    let VerificationResult { machine, verdict, .. } = verified;
    let size = machine.volume_mm;
    let mut lines = vec![if verified.is_proved() { "proved".to_owned() } else { "NOT proved".to_owned() }];
    lines.push(format!("placements      {}", verdict.bodies.len()));
    lines.push(format!("build volume    {} x {} x {} mm", size.x, size.y, size.z));
    if !machine.keep_out.is_empty() {
        lines.push(format!("keep-out boxes  {}", machine.keep_out.len()));
    }
    lines.push(format!("build height    {:.4} mm", verified.height_mm));
    lines.push(match verdict.placement_checks.proof.clearance_proved_mm {
        Some(least) => format!("least distance  {least:.6} mm, {} mm asked", machine.clearance_mm),
        None => format!("least distance  more than twice the {} mm asked", machine.clearance_mm),
    });
    if machine.margins != VolumeMargins::default() {
        let VolumeMargins { wall_mm, floor_mm, lid_mm } = machine.margins;
        lines.push(format!("kept free       {wall_mm} mm at the walls, {floor_mm} at the floor, {lid_mm} at the lid"));
    }
    if machine.clearance_z_extra_mm > 0.0 {
        lines.push(format!("raised parts    keep it, too, up to {} mm", machine.clearance_z_extra_mm));
    }
    let gap_mm = nester::removal_gap_mm(machine.clearance_mm);
    lines.push(match verdict.placement_checks.locked_bodies().len() {
        _ if verdict.placement_checks.disassembly.is_none() => "comes apart     not asked".to_owned(),
        0 => format!("comes apart     part by part, {gap_mm} mm kept on the way"),
        locked => format!("comes apart     not, {locked} parts are locked"),
    });
    lines.extend(verified.fault_lines());
    lines
}

fn as_json(verified: &VerificationResult) -> Value {
    let VerificationResult { info, machine, verdict, .. } = verified;
    let name = |i: usize| json!({ "item": i + 1, "name": verdict.bodies[i].name });
    let named = |bodies: &[usize]| bodies.iter().map(|&i| name(i)).collect::<Vec<_>>();
    let checks = &verdict.placement_checks;
    let proof = &checks.proof;
    let pairs: Vec<Value> = (proof.too_close.iter())
        .map(|p| {
            json!({ "first": name(p.first), "second": name(p.second), "distance_mm": p.distance_mm, "wanted_mm": p.wanted_mm })
        })
        .collect();
    let outside: Vec<Value> =
        proof.outside.iter().map(|&(i, excess)| json!({ "part": name(i), "excess_mm": excess })).collect();
    let inside: Vec<Value> =
        proof.inside.iter().map(|&(outer, inner)| json!({ "outer": name(outer), "inner": name(inner) })).collect();
    let intruding: Vec<Value> =
        proof.intruding.iter().map(|&(i, zone)| json!({ "part": name(i), "keep_out": zone + 1 })).collect();
    json!({
        "proved": verified.is_proved(),
        "title": info.heading.title,
        "application": info.heading.application,
        "machine": info.heading.machine,
        "placements": verdict.bodies.len(),
        "volume_mm": machine.volume_mm.to_array(),
        "height_mm": verified.height_mm,
        "clearance_mm": machine.clearance_mm,
        "clearance_z_extra_mm": machine.clearance_z_extra_mm,
        "margins_mm": machine.margins.as_dvec3().to_array(),
        "least_distance_mm": proof.clearance_proved_mm,
        "too_close": pairs,
        "outside": outside,
        "inside": inside,
        "keep_out": machine.keep_out.len(),
        "intruding": intruding,
        "interlock": machine.interlock.as_str(),
        "locked": checks.disassembly.as_ref().map(|apart| named(&apart.locked)),
        "turned": named(&verdict.wrongly_turned),
        "layers": checks.layers,
        "second_reader": verdict.second_reader_error,
        "list": verified.list_faults,
    })
}
