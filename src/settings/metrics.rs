//! Where the metrics are written, for those who read them from a file.

use std::path::PathBuf;

use serde::Serialize;

use super::{inputs::MetricsInputs, judge::Judge};

/// What node_exporter's textfile collector reads; other names it leaves alone.
const SUFFIX: &str = "prom";

/// The file that holds the metrics.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MetricsFile {
    /// Its name, absolute.
    pub path: PathBuf,
    /// It is written anew so often, seconds.
    pub every_secs: f64,
}

/// The file; `None` when there is none. What makes no sense is objected to.
pub(super) fn metrics(inputs: &MetricsInputs, judge: &mut Judge) -> Option<MetricsFile> {
    judge.within("metrics.every_secs", inputs.every_secs.0, 1.0..=3600.0);
    let path = inputs.textfile.0.clone()?;
    if !path.is_absolute() || path.extension().is_none_or(|end| end != SUFFIX) {
        let text = format!("metrics.textfile = \"{}\" is not read by node_exporter", path.display());
        let remedy = "give the whole path of a file that ends in .prom, or \"off\"";
        judge.object("metrics.textfile", text, remedy);
    }
    Some(MetricsFile { path, every_secs: inputs.every_secs.0 })
}
