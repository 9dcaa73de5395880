//! nestd: the daemon that runs a powder-bed print farm.
//!
//! The modules follow the life of a part: dropped, claimed, read, waiting, batched, nested, verified, published,
//! history. They are arranged in layers ("floors"), which ARCHITECTURE.md draws: a module may use only the floors below its own, and
//! `tests/it/floors.rs` enforces this.

pub mod cli;
pub mod metrics;
pub mod outbox;
pub mod tables;
pub mod web;
