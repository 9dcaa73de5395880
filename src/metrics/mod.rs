//! The farm's metrics for Prometheus, computed from the ledger at each request: base units, the prefix `nestd_`, labels
//! only from the configuration or from a small fixed set. The dashboard serves them at `/metrics`. Where no port is
//! wanted, they are written to a file for node_exporter.
//!
//! The module does not depend on the farm: it reads the ledger only, so `nestd metrics` gives the same numbers for a
//! farm whose daemon is dead.

mod counters;
mod gauges;
mod text_format;
mod textfile;

#[cfg(test)]
mod tests;

pub use text_format::{CONTENT_TYPE, MetricsExporter};
pub use textfile::keep_metrics_file;
