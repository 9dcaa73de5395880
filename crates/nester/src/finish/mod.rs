//! What follows a search or judges it: ties of equal height, look-alike copies set apart, what was left out, and the report.

pub(super) mod left_out;
pub(super) mod look_alikes;
pub(super) mod report;
pub(super) mod tie_break;
