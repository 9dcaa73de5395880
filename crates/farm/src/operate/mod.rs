//! What people say, whichever face says it: words about builds, and commands for the daemon.

pub(super) mod commands;
pub(super) mod operate;
