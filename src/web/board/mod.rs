//! The board of the farm, and the page of all components.

pub(super) mod components;
