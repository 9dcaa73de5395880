//! Much, large and damaged: floods of files, heavy parts, hostile bytes, ledgers of ten years.

pub mod flood;
pub mod heavy;
pub mod hostile;
pub mod intake;
pub mod large_ledger;
pub mod ledger;
pub mod memory;
pub mod torture;
