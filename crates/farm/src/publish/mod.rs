//! A proved build goes to its printer, exactly once: published, taken back to wait again or for another printer, looked after while it lies there.
//!
//! Whatever changes a queue is decided here. `staged_build` has the rename that publishes; `taken_file` publishes what is moved to another printer.

mod build_move;
pub(super) mod publish;
pub(super) mod queue_look;
mod staged_build;
pub(super) mod take_back;
mod taken_file;
pub(super) mod withdrawal;
