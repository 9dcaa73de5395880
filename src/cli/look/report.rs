//! `nestd report`: writes a build as one HTML file to mail.

use std::path::PathBuf;

use anyhow::Result;

use crate::{
    cli::{
        CommandExit, CommonArgs,
        terminal::build_lookup::{BuildLookupArgs, BuildSource, find_build, write_output},
    },
    web,
};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct ReportArgs {
    #[command(flatten)]
    build: BuildLookupArgs,
    /// HTML file to write, - for standard output [default: the build's name with .html, in this folder]
    #[arg(short = 'o', long = "output", value_name = "F.html")]
    output: Option<PathBuf>,
}

/// Runs the command.
pub fn run(common: &CommonArgs, args: &ReportArgs) -> Result<CommandExit> {
    let lookup = find_build(common, &args.build)?;
    let source = match &lookup.source {
        BuildSource::Ledger(build, profile) => web::ReportSource::Ledger(build, profile),
        BuildSource::File(file, info) => web::ReportSource::File(file, info),
    };
    let html = web::HtmlReport { cake: &lookup.cake, source }.to_html()?;
    let target = args.output.clone().unwrap_or_else(|| format!("{}.html", lookup.source.output_stem()).into());
    write_output(&target, html.as_bytes())
}
