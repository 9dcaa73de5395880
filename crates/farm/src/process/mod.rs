//! The process around the farm: time, threads, signals and systemd.
//!
//! Knows no part and no build.

pub(super) mod cpu_meter;
pub(super) mod ledger_changes;
pub(super) mod retry_backoff;
pub(super) mod signals;
pub(super) mod systemd;
pub(super) mod thread_priority;
pub(super) mod tick_tasks;
pub(super) mod time_source;
pub(super) mod time_text;
pub(super) mod wall_clock;
