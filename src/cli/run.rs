//! `nestd run`: the daemon in the foreground.

use std::{
    sync::{Arc, Mutex, PoisonError, RwLock},
    time::Duration,
};

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

/// Between two looks whether anybody is to be told anything.
const LOOK_EVERY: Duration = Duration::from_secs(1);

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
    let web = settings.web.clone();
    let shared: Shared = Arc::new(RwLock::new(Arc::new(settings)));
    let (told, served) = (shared.clone(), web.clone());
    let load = move || {
        let settings = load()?;
        if settings.web != served {
            tracing::warn!("What [web] says now is taken at the next start.");
        }
        *told.write().unwrap_or_else(PoisonError::into_inner) = Arc::new(settings.clone());
        Ok(settings)
    };
    let outside = farm::Outside::default();
    runtime.spawn(watch(shared, web, outside.clone()));
    let result = runtime.block_on(farm::run(Box::new(load), outside));
    // Jobs run on threads of their own; what has not ended by now finds its work again at the next start.
    if let Some(watching) = WATCHING.lock().unwrap_or_else(PoisonError::into_inner).take() {
        watching.shutdown_background();
    }
    runtime.shutdown_background();
    result.map(|()| Exit::Success)
}

/// Threads for tasks, and at most so many for what blocks.
fn threads(name: &str, blocking: usize) -> Result<Runtime> {
    let mut builder = tokio::runtime::Builder::new_multi_thread();
    builder.worker_threads(2).max_blocking_threads(blocking).thread_name(name).enable_all();
    builder.build().context("starting the runtime")
}

/// Whoever watches has threads of its own: one that hangs, on a share or a pipe, holds up nobody but the others there. A farm
/// that nobody watches has none.
static WATCHING: Mutex<Option<Runtime>> = Mutex::new(None);

/// Begins to show and to tell as soon as somebody is to be shown or told anything; the settings may change that at any time.
async fn watch(shared: Shared, web: Option<settings::Web>, outside: farm::Outside) {
    let begun = async {
        if let Err(failure) = outbox::forget_others(&shared).await {
            tracing::debug!("Receivers that are not configured could not be forgotten: {failure:#}.");
        }
        while !is_anybody_told(&shared) && web.is_none() {
            tokio::time::sleep(LOOK_EVERY).await;
        }
        let watching = match threads("nestd-watch", 8) {
            Ok(watching) => watching,
            Err(failure) => return outside.fails(&format!("{failure:#}")),
        };
        watching.spawn(tell(shared.clone(), outside.clone()));
        if let Some(web) = web {
            watching.spawn(serve(shared, web, outside.clone()));
        }
        *WATCHING.lock().unwrap_or_else(PoisonError::into_inner) = Some(watching);
    };
    outside.while_open(begun).await;
}

fn is_anybody_told(shared: &Shared) -> bool {
    let settings = shared.read().unwrap_or_else(PoisonError::into_inner);
    settings.metrics.is_some() || !outbox::configured(&settings.notify).is_empty()
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
async fn tell(shared: Shared, outside: farm::Outside) {
    let trouble = |receiver: Receiver, why| outside.receiver(&receiver.to_string(), why);
    let telling = async {
        tokio::join!(metrics::keep(shared.clone()), outbox::serve(shared.clone(), trouble));
    };
    outside.while_open(telling).await;
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
