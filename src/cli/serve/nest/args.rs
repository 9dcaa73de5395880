//! The options of `nestd nest`.

use std::path::PathBuf;

use glam::DVec3;
use nester::{FaceNotDown, InterlockRule, NestingMethod, OrientationRule, TiltLimit, VolumeMargins};
use settings::parse_secs;

use crate::cli::terminal::values::{parse_distance, parse_margins, parse_share, parse_volume, parse_word};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Exit code 0 everything placed and proved, 1 a copy could not be placed (the rest is still written), \
                        2 wrong use.\n\nCtrl-C ends the search: what it has found is proved and written. A second one \
                        ends the program.",
    group = clap::ArgGroup::new("volume_of").args(["machine", "volume"]).multiple(true).required(true)
)]
pub struct NestArgs {
    #[command(flatten)]
    pub(super) source: PartSource,
    #[command(flatten)]
    pub(super) machine: MachineChoice,
    #[command(flatten)]
    pub(super) search: SearchChoice,
    #[command(flatten)]
    pub(super) turning: TurningChoice,
    /// Folder that caches work on meshes between runs
    #[arg(long, value_name = "DIR")]
    pub(super) cache: Option<PathBuf>,
    #[command(flatten)]
    pub(super) files: OutputFiles,
}

// Groups of options. They have no doc comments, because clap would print those as the description of the command.
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
    /// Machine: its volume, margins, clearance, orientation rule and search parameters
    #[arg(long, value_name = "MACHINE")]
    pub(super) machine: Option<String>,
    /// Build volume in mm, e.g. 200x200x200 [default: the machine's]
    #[arg(long, value_name = "XxYxZ", value_parser = parse_volume)]
    pub(super) volume: Option<DVec3>,
    /// Least distance between two parts, mm [default: the machine's, else 3]
    #[arg(long, value_name = "MM", value_parser = parse_distance)]
    pub(super) clearance: Option<f64>,
    /// The clearance also holds when either of two parts is raised by up to this, mm [default: the machine's, else 0]
    #[arg(long, value_name = "MM", value_parser = parse_distance)]
    pub(super) clearance_z_extra: Option<f64>,
    /// Kept free, mm: all around, or along the walls, above the floor and below the lid [default: the machine's, else 0]
    #[arg(long, value_name = "MM|WALL,FLOOR,LID", value_parser = parse_margins)]
    pub(super) margins: Option<VolumeMargins>,
    /// No layer is filled beyond this share of the base, e.g. 0.3 [default: the machine's, else any]
    #[arg(long, value_name = "SHARE", value_parser = parse_share)]
    pub(super) layer_area_cap: Option<f64>,
}

#[derive(Debug, clap::Args)]
pub(super) struct SearchChoice {
    /// Search: our own or the published one [default: the machine's, else nestd]
    #[arg(long, value_name = "METHOD", value_parser = parse_word::<NestingMethod>)]
    pub(super) method: Option<NestingMethod>,
    /// Time to search, e.g. 60s or 2m; the search ends sooner when no lower layout exists
    #[arg(long, value_name = "TIME", default_value = "30s", value_parser = parse_budget)]
    pub(super) budget: f64,
    /// Search for this many evaluations instead: gives the same placements every time
    #[arg(long, value_name = "N", conflicts_with = "budget", value_parser = clap::value_parser!(u64).range(1..))]
    pub(super) evaluations: Option<u64>,
    /// Search on, in rounds that double from the budget on, until no lower layout exists, the patience is over, or Ctrl-C
    #[arg(long, conflicts_with = "evaluations")]
    pub(super) until_bound: bool,
    /// End when nothing was gained for this time, e.g. 40s
    #[arg(long, value_name = "TIME", conflicts_with = "evaluations", value_parser = parse_budget)]
    pub(super) patience: Option<f64>,
    /// Threads of the search; 0 = one per core [default: the machine's, else 1]
    #[arg(long, value_name = "T")]
    pub(super) threads: Option<usize>,
    /// Lanes: searches side by side that exchange their layouts; a repeatable build needs the same number; 0 = one per
    /// thread [default: the machine's, else 0]
    #[arg(long, value_name = "L")]
    pub(super) lanes: Option<usize>,
    /// Seed of every random choice [default: the machine's, else 1]
    #[arg(long, value_name = "S")]
    pub(super) seed: Option<u64>,
}

#[derive(Debug, clap::Args)]
pub(super) struct TurningChoice {
    /// How parts may be turned: free, upright (about z), axis (24 rotations) or fixed [default: the machine's, else free]
    #[arg(long, value_name = "RULE", value_parser = parse_word::<OrientationRule>)]
    pub(super) orientation: Option<OrientationRule>,
    /// Parts locked into each other: forbid (the search avoids them), warn or allow [default: the machine's, else
    /// forbid]
    #[arg(long, value_name = "RULE", value_parser = parse_word::<InterlockRule>)]
    pub(super) interlock: Option<InterlockRule>,
    /// A direction of the parts that must stay within DEG degrees of up, e.g. 0,0,1:30; may be given several times
    #[arg(long, value_name = "X,Y,Z:DEG", allow_hyphen_values = true, value_parser = str::parse::<TiltLimit>)]
    pub(super) keep_up: Vec<TiltLimit>,
    /// A face of the parts, by its outward normal, that must not face down: it stays at least DEG degrees (else 45)
    /// from down
    #[arg(long, value_name = "X,Y,Z[:DEG]", allow_hyphen_values = true, value_parser = str::parse::<FaceNotDown>)]
    pub(super) not_down: Vec<FaceNotDown>,
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

fn parse_budget(text: &str) -> Result<f64, String> {
    parse_secs(text).and_then(|secs| if secs > 0.0 { Ok(secs) } else { Err("wants some time, e.g. 60s".to_owned()) })
}
