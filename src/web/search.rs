//! What the report of the search tells of a build, as long as it lies beside the build file.

use std::{path::Path, sync::Arc, time::Duration};

use super::{scene::version, server::Web};
use crate::{intake, ledger::BuildRow, nest::DrawnCopy, settings::Profile};

/// A queue folder that does not answer within this time is not waited for.
const PATIENCE: Duration = Duration::from_secs(2);

/// What a report is read of at most.
const MAX_REPORT_BYTES: u64 = 32 << 20;

/// Reports that are kept.
pub(super) const KEPT: usize = 8;

/// What pages show of it.
#[derive(Debug, Default)]
pub(super) struct Told {
    /// (seconds, height in mm) of every improvement.
    pub(super) curve: Vec<(f64, f64)>,
    /// The copies in an order in which they can be drawn out, as it was proved; empty where that is not known of all.
    pub(super) order: Vec<DrawnCopy>,
}

impl Told {
    /// From the folder that a build file lies in; nothing when there is no report.
    pub(super) fn beside(folder: &Path, file_name: Option<&str>) -> Self {
        let read = || -> Option<serde_json::Value> {
            let stem = file_name?.strip_suffix(".build.3mf")?;
            // Others may write into this folder.
            let report = intake::read_start(&folder.join(format!("{stem}.report.json")), MAX_REPORT_BYTES).ok()??;
            serde_json::from_slice(&report).ok()
        };
        let report = read().unwrap_or_default();
        let apart = &report["separable"];
        let is_whole = apart["locked"].as_array().is_some_and(Vec::is_empty);
        let order = serde_json::from_value(apart["order"].clone()).ok().filter(|_| is_whole);
        Self {
            curve: serde_json::from_value(report["curve"].clone()).unwrap_or_default(),
            order: order.unwrap_or_default(),
        }
    }

    /// Of a build in the ledger; nothing while the queue folder is away or does not answer.
    pub(super) async fn of_build(web: &Web, profile: &Profile, build: &BuildRow) -> Arc<Self> {
        let key = version(build);
        if let Some(told) = web.told.get(&key) {
            return told;
        }
        let told = Arc::new(Self::read(web, profile, build).await);
        // A report that could not be read may be readable later.
        if !told.curve.is_empty() {
            web.told.put(key, told.clone());
        }
        told
    }

    async fn read(web: &Web, profile: &Profile, build: &BuildRow) -> Self {
        let stations = web.ledger.stations().await.unwrap_or_default();
        if stations.iter().any(|station| station.profile == profile.name && !station.trouble.is_empty()) {
            return Self::default();
        }
        let (folder, name) = (profile.folders.queue.clone(), build.file_name.clone());
        let read = tokio::task::spawn_blocking(move || Self::beside(&folder, name.as_deref()));
        tokio::time::timeout(PATIENCE, read).await.ok().and_then(Result::ok).unwrap_or_default()
    }
}
