//! What follows a search or judges it: the bound below which no layout lies, ties of equal height, look-alike copies set apart, what was left out, and the report.

pub(super) mod height_bound;
pub(super) mod left_out;
pub(super) mod look_alikes;
pub(super) mod report;
pub(super) mod tie_break;
