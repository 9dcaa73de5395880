//! A ledger that fails, is locked, lost or put back.

pub(super) mod failing_ledger;
pub(super) mod ledger_in_use;
pub(super) mod repair;
pub(super) mod restored;
mod taken_back;
