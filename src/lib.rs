//! nestd: the daemon that runs a powder-bed print farm.
//!
//! The modules follow the life of a part: dropped, claimed, read, waiting, batched, nested, verified, published,
//! history. Modules are arranged in layers ("floors"). A module may use only the floors below its own;
//! `tests/it/floors.rs` enforces this.
//!
//! ```text
//! 9  cli                      the face to terminals: parse, print; no decisions
//! 8  web                      the face to browsers
//! 7  tables                   what both show: each field's label, unit and print, each table's columns
//! 6  farm  outbox             the service: one file per step of a part's life, one event loop | its numbers | its messages
//! 5  settings                 TOML fragments -> validated Settings
//! 4  queue                    printer queue folder
//! 3  build                    machine + parts -> instance; solution -> a proved build file
//! ```
//!
//! Separate crates stand between and below: `ledger` (SQL) and `intake` (the hot folder) beside `queue`; `access` (mode and group of
//! files), `nester` (the packing search) and `build_file` (STL and 3MF in, build files and pictures out) below `build`; `sample_parts`
//! (the project's own parts), `solids` (meshes, poses, distances) and `jobs` (work beside an event loop) at the bottom.

pub mod build;
pub mod cli;
pub mod farm;
pub mod metrics;
pub mod outbox;
pub mod queue;
pub mod settings;
pub mod tables;
pub mod web;
