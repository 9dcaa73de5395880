//! Commands that run and keep a farm, or need none: the daemon, checks, copies, a new farm, the demo, one nesting.

pub(super) mod backup;
pub(super) mod check;
pub(super) mod completions;
pub(super) mod demo;
pub(super) mod ledger;
pub(super) mod manual;
pub(super) mod nest;
pub(super) mod new_farm;
pub(super) mod run;
pub(super) mod verify;
