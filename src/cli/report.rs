//! `nestd report`: a build as one HTML file to mail.

use std::path::PathBuf;

use anyhow::Result;

use super::{
    Common, Exit,
    looked::{BuildArgs, Source, hand_over, look},
};
use crate::web;

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    build: BuildArgs,
    /// HTML file to write, - for standard output [default: the build's name with .html, in this folder]
    #[arg(short = 'o', long = "output", value_name = "F.html")]
    output: Option<PathBuf>,
}

/// Runs the command.
pub fn run(common: &Common, args: &Args) -> Result<Exit> {
    let looked = look(common, &args.build)?;
    let source = match &looked.source {
        Source::Ledger(build, profile) => web::Source::Ledger(build, profile),
        Source::File(file, info) => web::Source::File(file, info),
    };
    let html = web::Report { cake: &looked.cake, source }.html()?;
    let target = args.output.clone().unwrap_or_else(|| format!("{}.html", looked.source.stem()).into());
    hand_over(&target, html.as_bytes())
}
