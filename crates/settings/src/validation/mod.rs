//! From all files to valid `Settings`, or to a list of all faults at once.

pub(super) mod load;
pub(super) mod printer_validation;
pub(super) mod profile_snapshot;
pub(super) mod validation_rules;
