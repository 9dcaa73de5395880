//! Builds from their first layout to the queue.

pub(super) mod build;
pub(super) mod nesting;
pub(super) mod night_search;
pub(super) mod placement;
pub(super) mod publish;
pub(super) mod second_file;
pub(super) mod take_back;
