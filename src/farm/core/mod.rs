//! The farm that all steps share: its state, its machines, and what halts it.

pub(super) mod clock_changes;
pub(super) mod command_answer;
pub(super) mod crash_guard;
pub(super) mod farm;
pub(super) mod job_events;
pub(super) mod machine_state;
pub(super) mod printer_state;
pub(super) mod state;
