//! The dashboard: pages over the ledger's queries, rendered on the server and readable without JavaScript, plus a JSON
//! interface and metrics for programs. It decides nothing: its commands go through the ledger, like those of the CLI.
//!
//! All assets are embedded in the binary, and no page loads anything from another host.

#[macro_use]
mod look;

mod base;
mod board;
mod break_out;
mod clients;
mod core;
mod doors;
mod figures;
mod forms;
mod help;
mod pages;
mod paper;
mod people;
mod serve;
#[cfg(test)]
mod tests;

pub use help::SETTINGS_CHAPTER;
pub use pages::report::{HtmlReport, ReportSource};
pub use serve::server::serve_dashboard;

pub(crate) use look::chip::Tone;
