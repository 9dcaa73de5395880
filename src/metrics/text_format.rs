//! The text format 0.0.4, as read by Prometheus, promtool and node_exporter.

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use anyhow::{Context, Result};
use ledger::{FarmTotals, Ledger};
use prometheus_client::{encoding::text::encode, registry::Registry};
use settings::Settings;
use tokio::sync::Mutex;

use super::{counters, gauges};

/// Content type of the text.
pub const CONTENT_TYPE: &str = "text/plain; version=0.0.4; charset=utf-8";

/// Maximum age of the totals, which take a scan of all rows.
const TOTALS_MAX_AGE: Duration = Duration::from_secs(60);

/// Renders the metrics and keeps the last totals.
#[derive(Debug, Default)]
pub struct MetricsExporter {
    totals: Mutex<Option<(Instant, Arc<FarmTotals>)>>,
}

impl MetricsExporter {
    /// All metrics at this moment, as text.
    ///
    /// # Errors
    /// The ledger cannot be read.
    pub async fn render_text(&self, ledger: &Ledger, settings: &Settings) -> Result<String> {
        let mut registry = Registry::with_prefix("nestd");
        gauges::register_gauges(&mut registry, ledger, settings).await?;
        counters::register_counters(&mut registry, &*self.cached_totals(ledger).await?, settings);
        let mut text = String::new();
        encode(&mut text, &registry).context("writing the metrics")?;
        Ok(convert_to_text_format(&text))
    }

    async fn cached_totals(&self, ledger: &Ledger) -> Result<Arc<FarmTotals>> {
        let mut kept = self.totals.lock().await;
        if let Some((at, totals)) = &*kept
            && at.elapsed() < TOTALS_MAX_AGE
        {
            return Ok(totals.clone());
        }
        let totals = Arc::new(ledger.read_totals().await?);
        *kept = Some((Instant::now(), totals.clone()));
        Ok(totals)
    }
}

/// Converts OpenMetrics, which the encoder writes, to the older text format, which every tool reads: there the
/// description of a counter has the same name as its samples, and there is no end marker.
fn convert_to_text_format(open_metrics: &str) -> String {
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
    assert_eq!(convert_to_text_format(open), text);
}
