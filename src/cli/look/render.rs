//! `nestd render`: draws a picture of a build.

use std::path::PathBuf;

use anyhow::Result;
use build_file::Viewpoint;

use crate::cli::{
    CommandExit, CommonArgs,
    terminal::{
        build_lookup::{BuildLookupArgs, find_build, write_output},
        values::parse_pixels,
    },
};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct RenderArgs {
    #[command(flatten)]
    build: BuildLookupArgs,
    /// Viewpoint of the picture
    #[arg(long, value_enum, default_value_t = RenderView::Iso)]
    view: RenderView,
    /// PNG to write, - for standard output [default: the build's name with .png, in this folder]
    #[arg(short = 'o', long = "output", value_name = "F.png")]
    output: Option<PathBuf>,
    /// Width and height, pixels
    #[arg(long, value_name = "WxH", default_value = "1024x768", value_parser = parse_pixels)]
    size: (u32, u32),
}

/// The viewpoints of a picture.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum RenderView {
    /// From the front, the right and above
    Iso,
    /// From above
    Top,
    /// From the front
    Front,
}

/// Runs the command.
pub fn run(common: &CommonArgs, args: &RenderArgs) -> Result<CommandExit> {
    let lookup = find_build(common, &args.build)?;
    let viewpoint = match args.view {
        RenderView::Iso => Viewpoint::Iso,
        RenderView::Top => Viewpoint::Top,
        RenderView::Front => Viewpoint::Front,
    };
    let target = args.output.clone().unwrap_or_else(|| format!("{}.png", lookup.source.output_stem()).into());
    write_output(&target, &lookup.cake.render_picture(viewpoint, args.size))
}
