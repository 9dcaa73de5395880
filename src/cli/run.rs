//! `nestd run`: the daemon in the foreground.

use std::sync::{Arc, PoisonError, RwLock};

use anyhow::{Context, Result};

use super::{Common, Exit, Usage, logging};
use crate::{
    farm, settings,
    web::{self, Shared},
};

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
    let web = settings.web.clone();
    let shared: Shared = Arc::new(RwLock::new(Arc::new(settings)));
    let told = shared.clone();
    let load = move || {
        let settings = load()?;
        *told.write().unwrap_or_else(PoisonError::into_inner) = Arc::new(settings.clone());
        Ok(settings)
    };
    if let Some(web) = web {
        // A dashboard that cannot be served is told; the farm works without it.
        runtime.spawn(async move {
            if let Err(failure) = web::serve(shared, web).await {
                tracing::error!("The dashboard is not served: {failure:#}. Mend it and restart nestd.");
            }
        });
    }
    let result = runtime.block_on(farm::run(Box::new(load)));
    // Jobs run on threads of their own; what has not ended by now finds its work again at the next start.
    runtime.shutdown_background();
    result.map(|()| Exit::Success)
}
