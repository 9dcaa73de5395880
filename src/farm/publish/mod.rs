//! A proved build goes to its printer, exactly once: published, taken back to wait again or for another printer, looked after while it lies there.
//!
//! Whatever changes a queue is decided here; the rename that publishes is in `records/staged_build`.

mod build_move;
pub(super) mod publish;
pub(super) mod queue_look;
pub(super) mod take_back;
mod taken_file;
pub(super) mod withdrawal;
