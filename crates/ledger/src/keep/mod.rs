//! Ledgers as files: copied, backed up, replaced, checked in depth, and what they do not know.

pub(super) mod backup;
pub(super) mod build_record;
pub(super) mod copy;
pub(super) mod damaged;
pub(super) mod decisions;
pub(super) mod deep_check;
mod record_rows;
pub(super) mod replace;
pub(super) mod unknown;
