//! Waiting parts are kept nested in an open build, lowered while threads are idle, fired, searched and written.

pub(super) mod batch;
pub(super) mod due_dates;
pub(super) mod nest;
pub(super) mod night_search;
