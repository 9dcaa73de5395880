//! The queues of printers: makes sure that a build file becomes visible to a printer exactly once.
//!
//! [`PrinterQueue`] says what the farm asks of a queue. The folder is the one kind today: [`PrinterQueue::stage`] writes the build under
//! a dot-name on the folder's own file system and fsyncs it. The ledger then says `verified`, and [`PrinterQueue::publish`] renames the
//! file once. After a crash [`PrinterQueue::state`] shows what happened: if the dot-file is still there, the build is not published; if
//! it is gone, the build was published, even if the printer has removed it since.
//!
//! What a build is delivered as (`build_file::DeliveryKind`) shows in the ending of its name only (`file_names`): it is one file whatever it
//! holds, so that one rename and one hash say what became of it.
//!
//! Another kind of queue is a file beside `queue_folder` with its `impl PrinterQueue`, a variant of [`QueueAddress`], and an option of `[[printer]]`
//! that makes one. It keeps what is staged and what was taken back on this machine, where it is read back and proved. What matches the variant says
//! what else must know it (`address`, `open`); a visible file is taken to have a local path (`QueueAddress::visible_file`), and the folder's place
//! is known to `settings/validation`, the invariants of the farm and `nestd check`.

mod address;
mod error;
mod file_names;
mod marker;
#[cfg(test)]
mod move_tests;
mod open;
mod printer_queue;
mod queue_folder;
mod take_back;
#[cfg(test)]
mod tests;

pub use address::QueueAddress;
pub use error::QueueError;
pub use printer_queue::{
    FileStamp, FileState, OpenQueue, PrinterQueue, PublishOutcome, StageWriter, TakeBackOutcome, is_build_name,
};
pub use queue_folder::QueueFolder;
