//! The printer queue folder: how a build file appears in it exactly once.
//!
//! [`Queue::stage`] writes and fsyncs the build under a dot-name on the queue's own file system, the ledger says
//! `verified`, [`Queue::publish`] renames it once. After a crash [`Queue::state`] tells: dot-file still there = not yet
//! published, gone = published, whatever the printer did with it since.

mod error;
mod marker;
mod names;
mod queue;
#[cfg(test)]
mod tests;

pub use error::QueueError;
pub use queue::{Published, Queue, StagedState};
