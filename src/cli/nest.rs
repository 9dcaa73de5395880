//! `nestd nest`: the whole nester without a farm. Parts in, a proved build file out.

mod output;
mod parts;
mod paths;
mod progress;

use std::{
    io::IsTerminal,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};
use glam::DVec3;

use super::{
    Common, Exit, Usage,
    table::tell,
    values::{distance, margins, share, volume, word},
};
use crate::{
    farm::DiskCache,
    format::{Arrangement, Instances, Limits, Unit},
    geometry::Bounds,
    nest::{
        self, BuildVolume, Config, DEFAULT_LAYER_MM, Instance, Interlock, Item, LayerCap, Margins, Method, NotDown,
        Orientation, OrientationRule, Solution, Tilt,
    },
    settings::{self, KeepOut, parse_secs},
};
use progress::{Budget, Progress};

/// Clearance without a profile and without `--clearance`, mm.
const DEFAULT_CLEARANCE_MM: f64 = 3.0;

/// What `--cache` may take up, bytes.
const CACHE_BYTES: u64 = 4 << 30;

/// Arguments of the command.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Exit code 0 everything placed and proved, 1 a copy could not be placed (the rest is still written), \
                        2 wrong use.",
    group = clap::ArgGroup::new("machine").args(["profile", "volume"]).multiple(true).required(true)
)]
pub struct Args {
    /// Parts (STL or 3MF), each with a number of copies after `=` [default: 1]
    #[arg(value_name = "PART[=COPIES]", required_unless_present = "list")]
    parts: Vec<String>,
    /// Parts as CSV with the columns file and quantity (or copies)
    #[arg(long, value_name = "PARTS.csv")]
    list: Option<PathBuf>,
    /// Folder that the list's files are relative to [default: the list's own]
    #[arg(long, value_name = "DIR", requires = "list")]
    base: Option<PathBuf>,
    /// Machine profile: its volume, margins, clearance, orientation rule and search parameters
    #[arg(long, value_name = "PROFILE")]
    profile: Option<String>,
    /// Build volume in mm, e.g. 200x200x200 [default: the profile's]
    #[arg(long, value_name = "XxYxZ", value_parser = volume)]
    volume: Option<DVec3>,
    /// Least distance between two parts, mm [default: the profile's, else 3]
    #[arg(long, value_name = "MM", value_parser = distance)]
    clearance: Option<f64>,
    /// The clearance also holds when either of two parts is raised by up to this, mm [default: the profile's, else 0]
    #[arg(long, value_name = "MM", value_parser = distance)]
    clearance_z_extra: Option<f64>,
    /// Kept free, mm: all around, or along the walls, above the floor and below the lid [default: the profile's, else 0]
    #[arg(long, value_name = "MM|WALL,FLOOR,LID", value_parser = margins)]
    margins: Option<Margins>,
    /// No layer is filled beyond this share of the base, e.g. 0.3 [default: the profile's, else any]
    #[arg(long, value_name = "SHARE", value_parser = share)]
    layer_area_cap: Option<f64>,
    /// Search: our own or the published one [default: the profile's, else nestd]
    #[arg(long, value_name = "METHOD", value_parser = word::<Method>)]
    method: Option<Method>,
    /// Time to search, e.g. 60s or 2m
    #[arg(long, value_name = "TIME", default_value = "30s", value_parser = budget)]
    budget: f64,
    /// Search for so many evaluations instead: the same placements every time
    #[arg(long, value_name = "N", conflicts_with = "budget", value_parser = clap::value_parser!(u64).range(1..))]
    evaluations: Option<u64>,
    /// Threads to search with; part of what makes a build repeatable; 0 = one per core [default: the profile's, else 1]
    #[arg(long, value_name = "T")]
    threads: Option<usize>,
    /// Seed of every random choice [default: the profile's, else 1]
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
    /// How parts may be turned: free, upright (about z), axis (24 rotations) or fixed [default: the profile's, else free]
    #[arg(long, value_name = "RULE", value_parser = word::<OrientationRule>)]
    orientation: Option<OrientationRule>,
    /// Parts locked into each other: forbid (the search keeps clear of them), warn or allow [default: the profile's, else
    /// forbid]
    #[arg(long, value_name = "RULE", value_parser = word::<Interlock>)]
    interlock: Option<Interlock>,
    /// A direction of the parts that must stand within so many degrees of up, e.g. 0,0,1:30; may be said several times
    #[arg(long, value_name = "X,Y,Z:DEG", allow_hyphen_values = true, value_parser = str::parse::<Tilt>)]
    keep_up: Vec<Tilt>,
    /// A face of the parts, by its outward normal, that must not look down; keeps so many degrees from it, else 45
    #[arg(long, value_name = "X,Y,Z[:DEG]", allow_hyphen_values = true, value_parser = str::parse::<NotDown>)]
    not_down: Vec<NotDown>,
    /// Folder where work on meshes is kept from one run to the next
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Build file to write, e.g. build.3mf
    #[arg(short = 'o', long = "output", value_name = "OUT.build.3mf")]
    output: PathBuf,
    /// Also write a report as JSON
    #[arg(long, value_name = "OUT.json")]
    report: Option<PathBuf>,
    /// Also write all placed parts as one binary STL
    #[arg(long, value_name = "OUT.stl")]
    stl: Option<PathBuf>,
}

/// What the machine asks for: the profile's word unless an option says otherwise.
struct Machine {
    name: String,
    /// The printable box, mm.
    volume_mm: DVec3,
    /// Boxes in which nothing may stand, in the machine's frame.
    keep_out: Vec<Bounds>,
    margins: Margins,
    clearance_mm: f64,
    clearance_z_extra_mm: f64,
    layer_mm: f64,
    layer_area_cap: Option<f64>,
    orientation: Orientation,
    unit: Unit,
    limits: Limits,
    config: Config,
    instances: Instances,
    arrangement: Arrangement,
}

impl Machine {
    /// Boxes in which nothing may stand, as the nester sees them.
    fn keep_out_in_room(&self) -> Vec<Bounds> {
        let origin_mm = self.origin_mm();
        let moved = |zone: &Bounds| Bounds { min: zone.min - origin_mm, max: zone.max - origin_mm };
        self.keep_out.iter().map(moved).collect()
    }

    /// The box that may be filled.
    fn room(&self) -> BuildVolume {
        self.margins.room(self.volume_mm)
    }

    /// Its layers, and how much of one may be filled.
    fn layer_cap(&self) -> LayerCap {
        LayerCap::of_share(self.layer_mm, self.layer_area_cap, &self.room())
    }

    /// Where its corner stands in the machine's frame, mm.
    fn origin_mm(&self) -> DVec3 {
        self.margins.origin_mm()
    }
}

/// Runs the command.
pub fn run(common: &Common, args: &Args) -> Result<Exit> {
    let machine = machine(common, args)?;
    let rows = parts::rows(args)?;
    paths::check(args, &rows)?;
    let parts = parts::read(rows, &machine)?;
    let item = |part: &parts::Part| Item {
        name: part.name.clone(),
        mesh: part.mesh.clone(),
        copies: part.copies,
        orientation: machine.orientation.clone(),
        clearance_mm: None,
    };
    let instance = Instance::new(machine.room(), machine.clearance_mm, parts.iter().map(item).collect())
        .and_then(|instance| instance.with_clearance_z_extra(machine.clearance_z_extra_mm))
        .and_then(|instance| instance.with_keep_out(&machine.keep_out_in_room()))
        .and_then(|instance| instance.with_layer_cap(machine.layer_cap()))
        .map_err(|error| Usage(error.to_string()))?;
    let cache = cache(args)?;
    let cache = cache.as_ref().map(|cache| cache as &dyn nest::Cache);
    let budget = Budget::starting_now(args.budget, args.evaluations);
    let mut progress = Progress::new(std::io::stderr().is_terminal(), budget.clone(), machine.origin_mm().z);
    let solution = nest::nest_with(&instance, &machine.config, &[], cache, &budget, &mut progress);
    let course = progress.finish(machine.config.seed);
    name_unplaced(&instance, &solution);
    let report = output::write(args, &machine, &parts, &instance, &solution, course)?;
    if std::io::stdout().is_terminal() {
        println!(
            "{:.2} mm high, {} of {} copies placed, density {:.3}, {:.1} s",
            report.height_mm,
            report.placed,
            instance.copies(),
            report.density,
            report.wall_secs
        );
    }
    Ok(if solution.unplaced.is_empty() { Exit::Success } else { Exit::Failure })
}

/// The cache that was asked for.
fn cache(args: &Args) -> Result<Option<DiskCache>> {
    let Some(dir) = &args.cache else { return Ok(None) };
    let opened = DiskCache::open(dir, CACHE_BYTES);
    opened.map(Some).map_err(|error| Usage(format!("--cache {}: {error}", dir.display())).into())
}

/// Says which copies found no place, and why where it is known.
fn name_unplaced(instance: &Instance, solution: &Solution) {
    for (at, item) in instance.items().iter().enumerate() {
        let left_out = solution.unplaced.iter().filter(|(of, _)| *of == at).count();
        if left_out == 0 {
            continue;
        }
        match nest::fits(&item.mesh, &item.orientation, &instance.volume()) {
            Ok(_) => tell(&format!("{}: {left_out} of {} copies found no place", item.name, item.copies)),
            Err(misfit) => tell(&format!("{}: {}", item.name, misfit.reason(&instance.volume()))),
        }
    }
}

fn machine(common: &Common, args: &Args) -> Result<Machine> {
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

fn budget(text: &str) -> Result<f64, String> {
    parse_secs(text).and_then(|secs| if secs > 0.0 { Ok(secs) } else { Err("wants some time, e.g. 60s".to_owned()) })
}

/// Reads a file's bytes for a hash, with the name in the error.
fn bytes_of(file: &Path) -> Result<Vec<u8>> {
    std::fs::read(file).with_context(|| format!("reading {}", file.display()))
}
