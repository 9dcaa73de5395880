#![doc = include_str!("../README.md")]
// The packing search. Its input is a `NestingInstance`, its output a `NestingSolution`. The crate uses no files, no
// log and no global state. A `StopCondition` ends the search, and a `ProgressListener` receives its progress.

mod finish;
mod orientation;
#[cfg(feature = "paper")]
mod paper;
mod pollination;
mod prepare;
mod problem;
mod proof;
mod search;
mod separation;
mod shapes;
mod start;
#[cfg(test)]
mod tests;

// Their types are in the interface.
pub use {glam, solids};

pub use finish::left_out::{LeftOutFit, examine_left_out};
pub use finish::look_alikes::{LookMeasures, set_look_alikes_apart};
pub use finish::report::{
    ClearanceMeasures, LockedCopy, NestingReport, PackingMeasures, PlacedPart, RemovedCopy, SearchCost, SearchSummary,
    Separability, UnplacedPart,
};
pub use orientation::orientation::OrientationLimits;
pub use orientation::orientation_rule::OrientationRule;
pub use orientation::tilt::{FaceNotDown, MAX_TILTS, TiltLimit, TiltLimitError, write_tilts};
pub use prepare::height_bound::lower_bound_mm;
pub use prepare::layers::LayerAreas;
pub use prepare::prepared_meshes::PreparedMeshes;
pub use problem::build_volume::{BuildVolume, VolumeMargins};
pub use problem::components::SearchComponents;
pub use problem::config::{InterlockRule, NestingConfig, NestingMethod};
pub use problem::fit_check::{FitFailure, find_fitting_rotation};
pub use problem::instance::{InstanceError, NestingInstance, NestingItem};
pub use problem::layer_cap::{DEFAULT_LAYER_MM, LayerAreaCap};
#[cfg(feature = "paper")]
pub use problem::paper_config::PaperConfig;
pub use problem::placement::ItemPlacement;
pub use problem::search_budget::SearchBudget;
pub use problem::search_control::{ProgressListener, StopCondition};
pub use problem::search_course::{HeightCurve, SearchEnd};
pub use problem::solution::NestingSolution;
pub use proof::{
    ClearanceViolation, Disassembly, LayoutProof, LayoutProver, PlacedSolid, find_removal_order, obeys_orientation,
    prove_layout, prove_placed_solids, prove_with_keep_out, prove_with_z_extra,
};
pub use search::improvement::{ImprovedLayouts, improve_layouts, nest_until_lowest};
pub use search::nester::{nest, nest_with_cache};
pub use search::nesting_search::NestingSearch;
pub use separation::disassembly::removal_gap_mm;
pub use shapes::cache::PreparedMeshCache;
pub use start::insert::insert_copies;
