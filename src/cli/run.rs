//! `nestd run`: the daemon in the foreground.

use anyhow::{Context, Result};

use super::{Common, Exit, Usage, logging};
use crate::{farm, settings};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct Args {}

/// Runs the command.
pub fn run(common: &Common, _args: &Args) -> Result<Exit> {
    let (config, root) = (common.config.clone(), common.root.clone());
    let load = move || settings::load(config.as_deref(), root.as_deref());
    // A wrong configuration is told before anything is opened.
    let settings = load().map_err(|error| Usage(error.to_string()))?;
    logging::start(&settings.log)?;
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build();
    let runtime = runtime.context("starting the runtime")?;
    let result = runtime.block_on(farm::run(Box::new(load)));
    // Jobs run on threads of their own; what has not ended by now finds its work again at the next start.
    runtime.shutdown_background();
    result.map(|()| Exit::Success)
}
