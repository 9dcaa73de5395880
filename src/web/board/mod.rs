//! The board of the farm, and the page of all components.

pub(super) mod axis;
pub(super) mod components;
pub(super) mod job;
pub(super) mod machine_row;
