//! Waiting parts are kept nested in an open build and fired (`batch`), lowered while threads are idle (`night_search`), and once fired
//! searched and written (`nest`). Each of the three begins searches with a policy of its own, and takes in what they find; `searches` starts all of them.

pub(super) mod batch;
pub(super) mod due_dates;
pub(super) mod nest;
pub(super) mod night_search;
mod searches;
