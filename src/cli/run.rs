//! `nestd run`: the daemon in the foreground.

use std::sync::{Arc, PoisonError, RwLock};

use anyhow::{Context, Result};
use tokio::runtime::Runtime;

use super::{Common, Exit, Usage, logging};
use crate::{
    access, farm,
    ledger::Receiver,
    metrics, outbox,
    settings::{self, Settings, Shared},
    web,
};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Run even as root, which may read and move everything that somebody links into a hot folder
    #[arg(long, env = "NESTD_ALLOW_ROOT", value_parser = clap::builder::FalseyValueParser::new())]
    allow_root: bool,
}

/// Runs the command.
pub fn run(common: &Common, args: &Args) -> Result<Exit> {
    let (config, root) = (common.config.clone(), common.root.clone());
    let load = move || settings::load(config.as_deref(), root.as_deref());
    // A wrong configuration is told before anything is opened.
    let settings = load().map_err(|error| Usage(error.to_string()))?;
    demand_little(&settings, args.allow_root)?;
    logging::start(&settings.log)?;
    let runtime = threads("nestd", 512)?;
    // Whoever watches has threads of its own: one that hangs, on a share or a pipe, holds up nobody but the others there.
    let watching = threads("nestd-watch", 8)?;
    let web = settings.web.clone();
    let shared: Shared = Arc::new(RwLock::new(Arc::new(settings)));
    let told = shared.clone();
    let load = move || {
        let settings = load()?;
        *told.write().unwrap_or_else(PoisonError::into_inner) = Arc::new(settings.clone());
        Ok(settings)
    };
    let outside = farm::Outside::default();
    tell_watchers(&watching, &shared, &outside);
    if let Some(web) = web {
        watching.spawn(serve(shared, web, outside.clone()));
    }
    let result = runtime.block_on(farm::run(Box::new(load), outside));
    // Jobs run on threads of their own; what has not ended by now finds its work again at the next start.
    watching.shutdown_background();
    runtime.shutdown_background();
    result.map(|()| Exit::Success)
}

/// Threads for tasks, and at most so many for what blocks.
fn threads(name: &str, blocking: usize) -> Result<Runtime> {
    let mut builder = tokio::runtime::Builder::new_multi_thread();
    builder.worker_threads(2).max_blocking_threads(blocking).thread_name(name).enable_all();
    builder.build().context("starting the runtime")
}

/// The dashboard, while the farm is open: the ledger may be opened only when it was found whole, and the address be taken only
/// by the one daemon that holds the farm. One that cannot be served is told; the farm works without it.
async fn serve(shared: Shared, web: settings::Web, outside: farm::Outside) {
    let serving = async {
        if let Err(failure) = web::serve(shared, web).await {
            outside.fails(&format!("{failure:#}"));
        }
    };
    outside.while_open(serving).await;
}

/// Those who watch the farm from outside are told by tasks beside it, while its ledger is open.
fn tell_watchers(runtime: &Runtime, shared: &Shared, outside: &farm::Outside) {
    let (shared, outside) = (shared.clone(), outside.clone());
    runtime.spawn(async move {
        let trouble = |receiver: Receiver, why| outside.receiver(&receiver.to_string(), why);
        let telling = async {
            tokio::join!(metrics::keep(shared.clone()), outbox::serve(shared.clone(), trouble));
        };
        outside.while_open(telling).await;
    });
}

/// The daemon takes files out of folders that anybody may write to: it must not be able to do more than that.
fn demand_little(settings: &Settings, allow_root: bool) -> Result<()> {
    if rustix::process::geteuid().is_root() && !allow_root {
        let text = "the daemon does not run as root: it takes files from folders that others write to. Run it as a user of its \
                    own (systemd/README.md says how), or say --allow-root";
        return Err(Usage(text.to_owned()).into());
    }
    match settings.files.group {
        Some(group) if !access::may_give_to(group) => {
            let text =
                format!("files.group: nestd's user is not in the group {group}; add it with usermod -aG {group} USER");
            Err(Usage(text).into())
        }
        _ => Ok(()),
    }
}
