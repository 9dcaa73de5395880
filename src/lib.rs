//! The faces of nestd, the daemon that runs a powder-bed print farm: command line, pages, tables, metrics, messages. The service is the crate
//! `farm`. The modules stand on floors, which ARCHITECTURE.md draws: a module may use only the floors below its own, and
//! `tests/it/floors.rs` enforces this.

pub mod cli;
pub mod metrics;
pub mod outbox;
pub mod tables;
pub mod web;
