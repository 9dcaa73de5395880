//! What lies in the queues, and what people say of it.

pub(super) mod closed_orders;
mod costs;
pub(super) mod deliveries;
mod kept_builds;
pub(super) mod life;
pub(super) mod printer_recovery;
pub(super) mod printers;
pub(super) mod queue_files;
pub(super) mod reprints;
pub(super) mod second_files;
pub(super) mod shrunk_machines;
pub(super) mod told;
pub(super) mod withdrawals;
