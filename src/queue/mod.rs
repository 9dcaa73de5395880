//! The printer queue folder: makes sure that a build file appears in it exactly once.
//!
//! [`QueueFolder::stage`] writes the build under a dot-name on the queue's own file system and fsyncs it. The ledger then
//! says `verified`, and [`QueueFolder::publish`] renames the file once. After a crash [`QueueFolder::staged_state`] shows what happened:
//! if the dot-file is still there, the build is not published; if it is gone, the build was published, even if the
//! printer has removed it since.

mod error;
mod file_names;
mod marker;
#[cfg(test)]
mod move_tests;
mod queue_folder;
#[cfg(test)]
mod tests;
mod withdrawal;

pub use error::QueueError;
pub use queue_folder::{PublishOutcome, QueueFolder, StagedState};
pub use withdrawal::WithdrawalOutcome;
