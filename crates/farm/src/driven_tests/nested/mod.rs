//! When a build fires, what is in it, and what is foretold.

pub(super) mod clock;
pub(super) mod dates;
pub(super) mod night;
pub(super) mod open_build;
pub(super) mod plans;
pub(super) mod precedence;
pub(super) mod triggers;
pub(super) mod waiting_times;
pub(super) mod week;
