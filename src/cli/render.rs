//! `nestd render`: the picture of a build.

use std::path::PathBuf;

use anyhow::Result;
use build_file::Viewpoint;

use super::{
    Common, Exit,
    looked::{BuildArgs, hand_over, look},
    values::pixels,
};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    build: BuildArgs,
    /// Where it is looked at from
    #[arg(long, value_enum, default_value_t = View::Iso)]
    view: View,
    /// PNG to write, - for standard output [default: the build's name with .png, in this folder]
    #[arg(short = 'o', long = "output", value_name = "F.png")]
    output: Option<PathBuf>,
    /// Width and height, pixels
    #[arg(long, value_name = "WxH", default_value = "1024x768", value_parser = pixels)]
    size: (u32, u32),
}

/// Where a build is looked at from.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum View {
    /// From the front, the right and above
    Iso,
    /// From above
    Top,
    /// From the front
    Front,
}

/// Runs the command.
pub fn run(common: &Common, args: &Args) -> Result<Exit> {
    let looked = look(common, &args.build)?;
    let viewpoint = match args.view {
        View::Iso => Viewpoint::Iso,
        View::Top => Viewpoint::Top,
        View::Front => Viewpoint::Front,
    };
    let target = args.output.clone().unwrap_or_else(|| format!("{}.png", looked.source.stem()).into());
    hand_over(&target, &looked.cake.picture(viewpoint, args.size))
}
