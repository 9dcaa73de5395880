//! The options of `nestd nest`.

use std::path::PathBuf;

use glam::DVec3;
use nester::{Interlock, Margins, Method, NotDown, OrientationRule, Tilt};

use crate::{
    cli::values::{distance, margins, share, volume, word},
    settings::parse_secs,
};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Exit code 0 everything placed and proved, 1 a copy could not be placed (the rest is still written), \
                        2 wrong use.",
    group = clap::ArgGroup::new("machine").args(["profile", "volume"]).multiple(true).required(true)
)]
pub struct Args {
    #[command(flatten)]
    pub(super) source: PartSource,
    #[command(flatten)]
    pub(super) machine: MachineChoice,
    #[command(flatten)]
    pub(super) search: SearchChoice,
    #[command(flatten)]
    pub(super) turning: TurningChoice,
    /// Folder where work on meshes is kept from one run to the next
    #[arg(long, value_name = "DIR")]
    pub(super) cache: Option<PathBuf>,
    #[command(flatten)]
    pub(super) files: OutputFiles,
}

// Groups of options; a doc comment on one would be taken for the description of the command.
#[derive(Debug, clap::Args)]
pub(super) struct PartSource {
    /// Parts (STL or 3MF), each with a number of copies after `=` [default: 1]
    #[arg(value_name = "PART[=COPIES]", required_unless_present = "list")]
    pub(super) parts: Vec<String>,
    /// Parts as CSV with the columns file and quantity (or copies)
    #[arg(long, value_name = "PARTS.csv")]
    pub(super) list: Option<PathBuf>,
    /// Folder that the list's files are relative to [default: the list's own]
    #[arg(long, value_name = "DIR", requires = "list")]
    pub(super) base: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
pub(super) struct MachineChoice {
    /// Machine profile: its volume, margins, clearance, orientation rule and search parameters
    #[arg(long, value_name = "PROFILE")]
    pub(super) profile: Option<String>,
    /// Build volume in mm, e.g. 200x200x200 [default: the profile's]
    #[arg(long, value_name = "XxYxZ", value_parser = volume)]
    pub(super) volume: Option<DVec3>,
    /// Least distance between two parts, mm [default: the profile's, else 3]
    #[arg(long, value_name = "MM", value_parser = distance)]
    pub(super) clearance: Option<f64>,
    /// The clearance also holds when either of two parts is raised by up to this, mm [default: the profile's, else 0]
    #[arg(long, value_name = "MM", value_parser = distance)]
    pub(super) clearance_z_extra: Option<f64>,
    /// Kept free, mm: all around, or along the walls, above the floor and below the lid [default: the profile's, else 0]
    #[arg(long, value_name = "MM|WALL,FLOOR,LID", value_parser = margins)]
    pub(super) margins: Option<Margins>,
    /// No layer is filled beyond this share of the base, e.g. 0.3 [default: the profile's, else any]
    #[arg(long, value_name = "SHARE", value_parser = share)]
    pub(super) layer_area_cap: Option<f64>,
}

#[derive(Debug, clap::Args)]
pub(super) struct SearchChoice {
    /// Search: our own or the published one [default: the profile's, else nestd]
    #[arg(long, value_name = "METHOD", value_parser = word::<Method>)]
    pub(super) method: Option<Method>,
    /// Time to search, e.g. 60s or 2m
    #[arg(long, value_name = "TIME", default_value = "30s", value_parser = budget)]
    pub(super) budget: f64,
    /// Search for so many evaluations instead: the same placements every time
    #[arg(long, value_name = "N", conflicts_with = "budget", value_parser = clap::value_parser!(u64).range(1..))]
    pub(super) evaluations: Option<u64>,
    /// Threads to search with; part of what makes a build repeatable; 0 = one per core [default: the profile's, else 1]
    #[arg(long, value_name = "T")]
    pub(super) threads: Option<usize>,
    /// Seed of every random choice [default: the profile's, else 1]
    #[arg(long, value_name = "S")]
    pub(super) seed: Option<u64>,
}

#[derive(Debug, clap::Args)]
pub(super) struct TurningChoice {
    /// How parts may be turned: free, upright (about z), axis (24 rotations) or fixed [default: the profile's, else free]
    #[arg(long, value_name = "RULE", value_parser = word::<OrientationRule>)]
    pub(super) orientation: Option<OrientationRule>,
    /// Parts locked into each other: forbid (the search keeps clear of them), warn or allow [default: the profile's, else
    /// forbid]
    #[arg(long, value_name = "RULE", value_parser = word::<Interlock>)]
    pub(super) interlock: Option<Interlock>,
    /// A direction of the parts that must stand within so many degrees of up, e.g. 0,0,1:30; may be said several times
    #[arg(long, value_name = "X,Y,Z:DEG", allow_hyphen_values = true, value_parser = str::parse::<Tilt>)]
    pub(super) keep_up: Vec<Tilt>,
    /// A face of the parts, by its outward normal, that must not look down; keeps so many degrees from it, else 45
    #[arg(long, value_name = "X,Y,Z[:DEG]", allow_hyphen_values = true, value_parser = str::parse::<NotDown>)]
    pub(super) not_down: Vec<NotDown>,
}

#[derive(Debug, clap::Args)]
pub(super) struct OutputFiles {
    /// Build file to write, e.g. build.3mf
    #[arg(short = 'o', long = "output", value_name = "OUT.build.3mf")]
    pub(super) output: PathBuf,
    /// Also write a report as JSON
    #[arg(long, value_name = "OUT.json")]
    pub(super) report: Option<PathBuf>,
    /// Also write all placed parts as one binary STL
    #[arg(long, value_name = "OUT.stl")]
    pub(super) stl: Option<PathBuf>,
}

fn budget(text: &str) -> Result<f64, String> {
    parse_secs(text).and_then(|secs| if secs > 0.0 { Ok(secs) } else { Err("wants some time, e.g. 60s".to_owned()) })
}
