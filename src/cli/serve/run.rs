//! `nestd run`: runs the daemon in the foreground.

use std::{
    sync::{Arc, Mutex, PoisonError, RwLock},
    time::Duration,
};

use anyhow::{Context, Result};
use ledger::{LedgerOnDemand, LedgerUser, ReceiverKind};
use settings::{Settings, SharedSettings};
use tokio::runtime::Runtime;

use crate::{
    cli::{CommandExit, CommonArgs, UsageError, terminal::logging},
    metrics, outbox, web,
};

/// Time between two checks whether the settings name any receiver.
const POLL_INTERVAL: Duration = Duration::from_secs(1);

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct RunArgs {
    /// Run even as root, although root may read and move any file that a user links into a hot folder
    #[arg(long, env = "NESTD_ALLOW_ROOT", value_parser = clap::builder::FalseyValueParser::new())]
    allow_root: bool,
}

/// Runs the command.
pub fn run(common: &CommonArgs, args: &RunArgs) -> Result<CommandExit> {
    let (config, root) = (common.config.clone(), common.root.clone());
    let load = move || settings::load_settings(config.as_deref(), root.as_deref());
    // A wrong configuration is reported before anything is opened.
    let settings = load().map_err(|error| UsageError(error.to_string()))?;
    check_privileges(&settings, args.allow_root)?;
    logging::start_logging(&settings.interfaces.log)?;
    let runtime = start_runtime("nestd", 512)?;
    let web = settings.interfaces.web.clone();
    let shared: SharedSettings = Arc::new(RwLock::new(Arc::new(settings)));
    let (outside, judged) = (farm::ServiceBridge::to_services_with(shared.clone()), farm::JudgedFiles::default());
    let serve_web = web.map(|web| serve_dashboard(shared.clone(), web, outside.clone(), judged.clone()));
    runtime.spawn(start_observers(shared, serve_web, outside.clone()));
    let result = runtime.block_on(farm::run(Box::new(load), outside, judged));
    // Jobs run on their own threads. A job that has not ended by now is repeated at the next start.
    if let Some(watching) = OBSERVER_RUNTIME.lock().unwrap_or_else(PoisonError::into_inner).take() {
        watching.shutdown_background();
    }
    runtime.shutdown_background();
    result.map(|()| CommandExit::Success)
}

/// Starts a runtime with two threads for tasks and at most `blocking` threads for blocking work.
fn start_runtime(name: &str, blocking: usize) -> Result<Runtime> {
    let mut builder = tokio::runtime::Builder::new_multi_thread();
    builder.worker_threads(2).max_blocking_threads(blocking).thread_name(name).enable_all();
    builder.build().context("starting the runtime")
}

/// The runtime of the dashboard, the metrics and the messages. A task that hangs, on a share or a pipe, cannot delay
/// the farm. A farm without dashboard, metrics and messages does not start this runtime.
static OBSERVER_RUNTIME: Mutex<Option<Runtime>> = Mutex::new(None);

/// Starts dashboard, metrics and messages as soon as the settings ask for any of them. The settings may change at any
/// time.
async fn start_observers(
    shared: SharedSettings,
    serve_web: Option<impl Future<Output = ()> + Send + 'static>,
    outside: farm::ServiceBridge,
) {
    let begun = async {
        if let Err(failure) = outbox::forget_unconfigured_receivers(&shared).await {
            tracing::debug!("Receivers that are not configured could not be forgotten: {failure:#}.");
        }
        while !has_receivers(&shared) && serve_web.is_none() {
            tokio::time::sleep(POLL_INTERVAL).await;
        }
        let watching = match start_runtime("nestd-watch", 8) {
            Ok(watching) => watching,
            Err(failure) => return outside.report_dashboard_failure(&format!("{failure:#}")),
        };
        watching.spawn(serve_monitoring(shared.clone(), outside.clone()));
        if let Some(serving) = serve_web {
            watching.spawn(serving);
        }
        *OBSERVER_RUNTIME.lock().unwrap_or_else(PoisonError::into_inner) = Some(watching);
    };
    outside.run_while_open(begun).await;
}

fn has_receivers(shared: &SharedSettings) -> bool {
    let settings = shared.read().unwrap_or_else(PoisonError::into_inner);
    settings.interfaces.metrics.is_some() || !outbox::configured_receivers(&settings.interfaces.notify).is_empty()
}

/// Serves the dashboard from when the farm is open: before that, the ledger is not checked yet, and this process may not be
/// the one daemon of the farm that may bind the address. Of a halted farm it only says why it has halted. A failure is reported; the
/// farm works without the dashboard.
async fn serve_dashboard(
    shared: SharedSettings,
    web: settings::WebSettings,
    outside: farm::ServiceBridge,
    judged: farm::JudgedFiles,
) {
    let serving = async {
        if let Err(failure) = web::serve_dashboard(shared, web, outside.clone(), judged).await {
            outside.report_dashboard_failure(&format!("{failure:#}"));
        }
    };
    outside.run_until_closed(serving).await;
}

/// Writes metrics and sends messages in tasks of their own, while its ledger is open.
async fn serve_monitoring(shared: SharedSettings, outside: farm::ServiceBridge) {
    let ledger = LedgerOnDemand::for_user(LedgerUser::Monitoring);
    let report_failure = |receiver: ReceiverKind, why| outside.report_receiver(&receiver.to_string(), why);
    let telling = async {
        tokio::join!(
            metrics::keep_metrics_file(shared.clone(), ledger.clone()),
            outbox::deliver_events(shared.clone(), ledger, report_failure)
        );
    };
    outside.run_while_open(telling).await;
}

/// Refuses to run with more privileges than needed: the daemon takes files from folders that anybody may write to.
fn check_privileges(settings: &Settings, allow_root: bool) -> Result<()> {
    if rustix::process::geteuid().is_root() && !allow_root {
        let text = "the daemon does not run as root: it takes files from folders that others write to. Run it as a user of its \
                    own (systemd/README.md says how), or say --allow-root";
        return Err(UsageError(text.to_owned()).into());
    }
    settings.files.ensure_assignable().map_err(|error| UsageError(error.to_string()).into())
}
