//! The service: one file per step of a part's life, one event loop.
//!
//! `receive` claims what was dropped, `read` checks it, `batch` keeps the open build and fires it, `nest` searches, `prove`
//! writes and judges, `publish` publishes. `farm` holds the state and the loop, `orders` what operators ask for.

mod attention;
mod back_off;
mod batch;
mod budget;
mod cache;
mod cake;
mod claimed;
mod clock;
mod due;
mod event;
mod farm;
mod holds;
mod invariants;
mod jobs;
mod layout;
mod lock;
mod nest;
mod notices;
mod open;
mod orders;
mod owner;
mod priority;
mod prove;
mod publish;
mod quiet;
mod read;
mod receive;
mod reconcile;
mod record;
mod restore;
mod sd;
mod shelf;
mod signals;
mod station;
mod stations;
mod status;
mod tidy;
mod trigger;
mod watched;

pub use attention::{Attention, Notice};
pub use budget::Budget;
pub use cache::DiskCache;
pub use cake::{Cake, CakePart, Standing, copies_so_far, file_in_queue, standing, volume_of};
pub use farm::{Load, run};
pub use invariants::{Invariant, Looked, Violation, Witness, invariants};
pub use notices::{Outside, in_json as notice_in_json, kept_notices};
pub use prove::faults_of;
pub use reconcile::{Reconciled, repair};
pub use restore::{Restored, restore};
pub use status::{Fires, fires_at};
pub use trigger::FiredBy;
