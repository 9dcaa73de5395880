//! The file to which metrics are written, for users who do not scrape a port.

use std::path::PathBuf;

use serde::Serialize;

use super::inputs::MetricsInputs;
use crate::reading::validator::ConfigValidator;

/// File extension that node_exporter's textfile collector requires.
const TEXTFILE_EXTENSION: &str = "prom";

/// The file that holds the metrics.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MetricsFile {
    /// Absolute path.
    pub path: PathBuf,
    /// Interval at which it is rewritten, seconds.
    pub every_secs: f64,
}

/// Validates the settings of the metrics file. `None` if there is none. Reports problems.
pub(crate) fn validate_metrics(inputs: &MetricsInputs, validator: &mut ConfigValidator) -> Option<MetricsFile> {
    validator.require_within("metrics.every_secs", inputs.every_secs.0, 1.0..=3600.0);
    let path = inputs.textfile.0.clone()?;
    if !path.is_absolute() || path.extension().is_none_or(|end| end != TEXTFILE_EXTENSION) {
        let text = format!("metrics.textfile = \"{}\" is not read by node_exporter", path.display());
        let remedy = "give the whole path of a file that ends in .prom, or \"off\"";
        validator.report_problem("metrics.textfile", text, remedy);
    }
    Some(MetricsFile { path, every_secs: inputs.every_secs.0 })
}
