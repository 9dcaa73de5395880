//! nestd: the daemon that runs a powder-bed print farm.
//!
//! A part's life is the plot of the code: dropped, claimed, read, waiting, batched, nested, verified, published, history.
//! Modules stand on floors; a module knows only floors below its own (`tests/it/floors.rs` enforces it).
//!
//! ```text
//! 8  cli                      the face to terminals: parse, print; no decisions
//! 7  web                      the face to browsers
//! 6  farm  metrics  outbox    the service: one file per step of a part's life, one event loop | its numbers | its messages
//! 5  settings                 TOML fragments -> validated Settings
//! 4  ledger  intake  queue    SQL | hot folder | printer queue folder
//! 3  build                    machine + parts -> instance; solution -> a proved build file
//! 2  format  access           STL/3MF bytes <-> Mesh; meshes + poses -> .build.3mf, previews | mode and group of files
//! 1  nest  samples            geometry x pollination: the packing search | the project's own parts
//! 0  geometry  pollination    pure solids | pure optimiser over &[f64]
//! ```

pub mod access;
pub mod build;
pub mod cli;
pub mod farm;
pub mod format;
pub mod geometry;
pub mod intake;
pub mod ledger;
pub mod metrics;
pub mod nest;
pub mod outbox;
pub mod pollination;
pub mod queue;
pub mod samples;
pub mod settings;
pub mod web;
