//! The face to browsers: pages over the ledger's queries, rendered on the server and readable without JavaScript; a JSON
//! interface and metrics for machines. It decides nothing: orders go through the ledger, as those of the command line do.
//!
//! Everything is embedded in the binary, and no page asks another host for anything.

mod admit;
mod api;
mod asked;
mod assets;
mod build;
mod cache;
mod chart;
mod door;
mod enum_words;
mod farm;
mod footprint;
mod guard;
mod history;
mod labels;
mod listing;
mod live;
mod metrics;
mod openapi;
mod order;
mod page;
mod part;
mod pick;
mod pick_map;
mod picture;
mod problem;
mod reduce;
mod render;
mod report;
mod scene;
mod search;
mod server;
mod sheets;
mod state;
mod words;

#[cfg(test)]
mod tests;

pub use report::{Report, Source};
pub use server::serve;
