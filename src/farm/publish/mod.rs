//! A proved build goes to its printer, exactly once: published, moved to another printer, taken back, looked after while it lies there.
//!
//! Every rename in a queue folder is here.

pub(super) mod build_move;
pub(super) mod publish;
pub(super) mod queue_look;
pub(super) mod withdrawal;
