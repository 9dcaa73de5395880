//! The farm's numbers for Prometheus, made of the ledger whenever they are asked for: base units, `nestd_` before every name,
//! labels only of what is configured or of few fixed words. The dashboard serves them at `/metrics`; where no port is wanted,
//! they are written into a file for node_exporter.
//!
//! The room stands beside the farm: it asks the ledger, as every face does, so that it needs nothing of the daemon's insides
//! and `nestd metrics` tells the same of a farm whose daemon is dead.

mod counted;
mod standing;
mod text;
mod textfile;

#[cfg(test)]
mod tests;

pub use text::{CONTENT_TYPE, Metrics};
pub use textfile::keep;
