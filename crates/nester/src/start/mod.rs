//! First layouts: parts are set one after the other by several recipes, by precedence, or beside those of an earlier layout.
//!
//! A first layout holds all clearances; `search` only lowers it.

pub(super) mod box_stacker;
pub(super) mod first_layouts;
pub(super) mod insert;
pub(super) mod layout_builder;
pub(super) mod lowest_layers;
pub(super) mod nesting_run;
pub(super) mod occupancy_grid;
pub(super) mod precedence;
pub(super) mod recipe;
pub(super) mod retained;
pub(super) mod truncate_queue;
