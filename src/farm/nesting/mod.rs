//! A search of the farm: its problem, its result written and proved.
//!
//! Works off the loop and touches no state of the farm.

pub(super) mod nest_decision;
pub(super) mod nesting_search;
pub(super) mod node_content;
pub(super) mod open_night;
pub(super) mod write_build;
