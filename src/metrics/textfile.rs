//! The metrics as a file, written anew every so often and at once as a whole: node_exporter never reads half of one.

use std::{
    fs::Permissions,
    io::Write,
    os::unix::fs::PermissionsExt,
    path::Path,
    sync::PoisonError,
    time::{Duration, Instant},
};

use anyhow::{Context, Result};
use tracing::{info, warn};

use super::Metrics;
use crate::{
    ledger::Ledger,
    settings::{MetricsFile, Settings, Shared},
};

/// Between two looks at whether it is time and whether the file is still wanted.
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// Everybody may read the file: node_exporter runs as another user.
const MODE: u32 = 0o644;

/// Keeps the file as the settings ask for it, until it is dropped. What fails is told once, and tried again.
pub async fn keep(settings: Shared) {
    let (metrics, mut ledger, mut written, mut failing) = (Metrics::default(), None, None::<Instant>, String::new());
    loop {
        tokio::time::sleep(LOOK_EVERY).await;
        let now = settings.read().unwrap_or_else(PoisonError::into_inner).clone();
        let Some(file) = &now.metrics else { continue };
        if written.is_some_and(|at| at.elapsed() < Duration::from_secs_f64(file.every_secs)) {
            continue;
        }
        written = Some(Instant::now());
        match write(&metrics, &mut ledger, &now, file).await {
            Ok(()) if failing.is_empty() => {}
            Ok(()) => {
                info!("The metrics are written into {} again.", file.path.display());
                failing.clear();
            }
            Err(failure) if format!("{failure:#}") == failing => {}
            Err(failure) => {
                failing = format!("{failure:#}");
                warn!("The metrics could not be written, which is tried again: {failing}.");
            }
        }
    }
}

async fn write(metrics: &Metrics, ledger: &mut Option<Ledger>, settings: &Settings, file: &MetricsFile) -> Result<()> {
    let ledger = match ledger {
        Some(ledger) => ledger,
        None => ledger.insert(Ledger::open_existing(&settings.ledger).await?),
    };
    let (text, path) = (metrics.text(ledger, settings).await?, file.path.clone());
    tokio::task::spawn_blocking(move || replace(&path, &text)).await.context("writing the metrics")?
}

fn replace(path: &Path, text: &str) -> Result<()> {
    let what = || format!("writing {}", path.display());
    let folder = path.parent().unwrap_or(Path::new("/"));
    // node_exporter reads only what ends in .prom.
    let mut file = tempfile::Builder::new().prefix(".nestd-").tempfile_in(folder).with_context(what)?;
    file.write_all(text.as_bytes()).with_context(what)?;
    file.as_file().set_permissions(Permissions::from_mode(MODE)).with_context(what)?;
    file.persist(path).with_context(what)?;
    Ok(())
}
