//! The daemon: it opens the farm, runs the loop over all steps, tells its status and tidies up.
//!
//! `event_loop` is the only file that knows all steps.

pub(super) mod event_loop;
pub(super) mod machine_setup;
pub(super) mod open;
pub(super) mod reload;
pub(super) mod status;
pub(super) mod status_alerts;
pub(super) mod tidy;
pub(super) mod unserved;
