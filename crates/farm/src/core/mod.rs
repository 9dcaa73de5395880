//! The farm: its state (`farm`, `state`, `machine_state`, `printer_state`), what halts it, and what each step may touch of it.
//!
//! A step never sees the farm. The event loop makes a desk for it (`desks`): `Serving` the machines with their folders and
//! printers, `Watching` the watch on the hot folders, `Showing` the status that people see, `SettingUp` the machines as they are
//! configured, `Storing` the store and what it forgets, `Receiving` parts until they wait or are refused, `Searching` open builds
//! that wait, `Building` fired builds until they lie in a queue, `Batching` what is received together with what is fired. Each has
//! `Shared`: settings to read, the ledger to work in, the daemon's life, alerts to raise, and the loop's schedule with its clock. The end of a job names its desk too. A step that cannot
//! rely on its ledger asks for a halt (`Shared::halt`), and the loop halts the farm as soon as that step has ended.

pub(super) mod clock_changes;
pub(super) mod command_answer;
pub(super) mod crash_guard;
pub(super) mod desks;
pub(super) mod farm;
pub(super) mod job_events;
pub(super) mod machine_state;
mod make_desks;
pub(super) mod printer_state;
mod run_step;
pub(super) mod state;
