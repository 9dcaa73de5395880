//! The text that Prometheus, promtool and node_exporter read: the text format 0.0.4.

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use anyhow::{Context, Result};
use prometheus_client::{encoding::text::encode, registry::Registry};
use tokio::sync::Mutex;

use super::{counted, standing};
use crate::{
    ledger::{Ledger, Totals},
    settings::Settings,
};

/// What is said of the text.
pub const CONTENT_TYPE: &str = "text/plain; version=0.0.4; charset=utf-8";

/// Totals look at every row: they are asked for again after so long.
const TOTALS_AGAIN: Duration = Duration::from_secs(60);

/// The metrics, with the totals as they were asked for last.
#[derive(Debug, Default)]
pub struct Metrics {
    totals: Mutex<Option<(Instant, Arc<Totals>)>>,
}

impl Metrics {
    /// All metrics as they are now.
    ///
    /// # Errors
    /// When the ledger does not answer.
    pub async fn text(&self, ledger: &Ledger, settings: &Settings) -> Result<String> {
        let mut registry = Registry::with_prefix("nestd");
        standing::register(&mut registry, ledger, settings).await?;
        counted::register(&mut registry, &*self.totals(ledger).await?, settings);
        let mut text = String::new();
        encode(&mut text, &registry).context("writing the metrics")?;
        Ok(in_text_format(&text))
    }

    async fn totals(&self, ledger: &Ledger) -> Result<Arc<Totals>> {
        let mut kept = self.totals.lock().await;
        if let Some((at, totals)) = &*kept
            && at.elapsed() < TOTALS_AGAIN
        {
            return Ok(totals.clone());
        }
        let totals = Arc::new(ledger.totals().await?);
        *kept = Some((Instant::now(), totals.clone()));
        Ok(totals)
    }
}

/// OpenMetrics, which the encoder writes, as the older text format, which everybody reads: there a counter is described under
/// the name that its samples have, and nothing ends the text.
fn in_text_format(open_metrics: &str) -> String {
    let is_counter = |name: &str| open_metrics.contains(&format!("# TYPE {name} counter\n"));
    let mut text = String::with_capacity(open_metrics.len());
    for line in open_metrics.lines().filter(|line| *line != "# EOF") {
        let mut words = line.splitn(4, ' ');
        match (words.next(), words.next(), words.next(), words.next()) {
            (Some("#"), Some(what), Some(name), Some(rest)) if is_counter(name) => {
                text += &format!("# {what} {name}_total {rest}\n");
            }
            _ => text += &format!("{line}\n"),
        }
    }
    text
}

#[test]
fn a_counter_is_described_under_the_name_of_its_samples() {
    let open = "# HELP a_b Of b.\n# TYPE a_b counter\na_b_total{x=\"# TYPE a_b counter\"} 1\n# HELP c Of c.\n# TYPE c gauge\nc 1\n# EOF\n";
    let text = "# HELP a_b_total Of b.\n# TYPE a_b_total counter\na_b_total{x=\"# TYPE a_b counter\"} 1\n# HELP c Of c.\n# TYPE c gauge\nc 1\n";
    assert_eq!(in_text_format(open), text);
}
