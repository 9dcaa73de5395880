//! The service: one file per step of a part's life, one event loop.
//!
//! `receive` claims what was dropped, `read` checks it, `batch` keeps the open build and fires it, `nest` searches, `prove`
//! writes and judges, `publish` publishes. `farm` holds the state and the loop, `orders` what operators ask for.

mod batch;
mod budget;
mod cache;
mod claimed;
mod event;
mod farm;
mod invariants;
mod jobs;
mod layout;
mod lock;
mod nest;
mod orders;
mod priority;
mod prove;
mod publish;
mod quiet;
mod read;
mod receive;
mod sd;
mod shelf;
mod signals;
mod station;
mod status;
mod tidy;
mod trigger;

pub use budget::Budget;
pub use cache::DiskCache;
pub use farm::{Load, run};
pub use invariants::{Invariant, Looked, Violation, Witness, invariants};
pub use prove::faults_of;
