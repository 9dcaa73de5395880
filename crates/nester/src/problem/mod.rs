//! What is asked and what is answered: the build volume, the items, the settings of a search, who ends it, and the poses that come back.
//!
//! A caller meets these types. They decide nothing about how to search.

pub(super) mod build_volume;
pub(super) mod components;
pub(super) mod config;
pub(super) mod fit_check;
pub(super) mod instance;
pub(super) mod instance_serde;
pub(super) mod layer_cap;
#[cfg(feature = "paper")]
pub(super) mod paper_config;
pub(super) mod placement;
pub(super) mod reserved;
pub(super) mod search_budget;
pub(super) mod search_control;
pub(super) mod search_course;
pub(super) mod solution;
