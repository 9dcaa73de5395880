//! The metrics as a file. It is replaced atomically at intervals, so node_exporter never reads half of it.

use std::{
    fs::Permissions,
    io::Write,
    os::unix::fs::PermissionsExt,
    path::Path,
    sync::PoisonError,
    time::{Duration, Instant},
};

use anyhow::{Context, Result};
use ledger::LedgerOnDemand;
use settings::{MetricsFile, Settings, SharedSettings};
use tracing::{info, warn};

use super::MetricsExporter;

/// Interval of the checks whether the file is due and still wanted.
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// Everybody may read the file: node_exporter runs as another user.
const MODE: u32 = 0o644;

/// Writes the file as configured until the future is dropped. A failure is logged once and retried.
pub async fn keep_metrics_file(settings: SharedSettings, ledger: LedgerOnDemand) {
    let (metrics, mut written, mut failing) = (MetricsExporter::default(), None::<Instant>, String::new());
    loop {
        tokio::time::sleep(LOOK_EVERY).await;
        let now = settings.read().unwrap_or_else(PoisonError::into_inner).clone();
        let Some(file) = &now.interfaces.metrics else { continue };
        if written.is_some_and(|at| at.elapsed() < Duration::from_secs_f64(file.every_secs)) {
            continue;
        }
        written = Some(Instant::now());
        match write_metrics(&metrics, &ledger, &now, file).await {
            Ok(()) if failing.is_empty() => {}
            Ok(()) => {
                info!("The metrics are written into {} again.", file.path.display());
                failing.clear();
            }
            Err(failure) if format!("{failure:#}") == failing => {}
            Err(failure) => {
                failing = format!("{failure:#}");
                warn!("The metrics could not be written; this is retried: {failing}.");
            }
        }
    }
}

async fn write_metrics(
    metrics: &MetricsExporter,
    ledger: &LedgerOnDemand,
    settings: &Settings,
    file: &MetricsFile,
) -> Result<()> {
    let ledger = ledger.get(&settings.ledger).await?;
    let (text, path) = (metrics.render_text(&ledger, settings).await?, file.path.clone());
    tokio::task::spawn_blocking(move || replace_file(&path, &text)).await.context("writing the metrics")?
}

fn replace_file(path: &Path, text: &str) -> Result<()> {
    let what = || format!("writing {}", path.display());
    let folder = path.parent().unwrap_or(Path::new("/"));
    // node_exporter reads only names that end in .prom.
    let mut file = tempfile::Builder::new().prefix(".nestd-").tempfile_in(folder).with_context(what)?;
    file.write_all(text.as_bytes()).with_context(what)?;
    file.as_file().set_permissions(Permissions::from_mode(MODE)).with_context(what)?;
    file.persist(path).with_context(what)?;
    Ok(())
}
