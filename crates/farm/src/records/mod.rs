//! What the folders tell, compared with the ledger: records of builds, notes of claims and orders, markers.
//!
//! It writes and removes such records; `invariants` says what must hold.

pub(super) mod build_record;
pub(super) mod cake;
pub(super) mod folder_builds;
pub(super) mod forgettable;
pub(super) mod forgotten_files;
pub(super) mod invariants;
pub(super) mod kept_build;
pub(super) mod ledger_freshness;
pub(super) mod lost_ledger;
pub(super) mod newer_decisions;
pub(super) mod order_notes;
pub(super) mod reconcile;
pub(super) mod reconcile_report;
pub(super) mod said_words;
