#![doc = include_str!("../README.md")]
// The packing search. Its input is a `NestingInstance`, its output a `NestingSolution`. The crate uses no files, no
// log and no global state. A `StopCondition` ends the search, and a `ProgressListener` receives its progress.

mod bounding_sphere;
mod box_stacker;
mod build_volume;
mod byte_codec;
mod cache;
mod components;
mod compression;
mod config;
mod disassembly;
mod distance_field;
mod exact_contacts;
mod first_layouts;
mod first_rotations;
mod fit_check;
mod height_bound;
mod hull_penetration;
mod improvement;
mod insert;
mod instance;
mod instance_serde;
mod interlock_check;
mod interlock_memory;
mod joint_motion;
mod lane_rounds;
mod lanes;
mod layer_cap;
mod layers;
mod layout_builder;
mod layout_parts;
mod left_out;
mod look_alikes;
mod lowest_layers;
mod nester;
mod nesting_run;
mod occupancy_grid;
mod orientation;
mod orientation_rule;
mod outline;
mod overlap_depth_grid;
mod pair_records;
#[cfg(feature = "paper")]
mod paper;
mod part_raster;
mod placement;
mod point_block;
mod pollination;
mod precedence;
mod preparation;
mod prepared_instance;
mod prepared_meshes;
mod proof;
mod proximity_grid;
mod recipe;
mod relocation;
mod report;
mod reserved;
mod retained;
mod rotations;
mod search_budget;
mod search_control;
mod separation;
mod separation_step;
mod shape;
mod skyline;
mod solid_nodes;
mod solution;
mod sphere_tree;
mod sphere_walk;
#[cfg(test)]
mod testing;
mod tie_break;
mod tilt;
mod tournament;
mod truncate_queue;
mod working_layout;

pub use build_volume::{BuildVolume, VolumeMargins};
pub use cache::PreparedMeshCache;
pub use components::SearchComponents;
pub use compression::DescentPace;
pub use config::{InterlockRule, NestingConfig, NestingMethod};
pub use disassembly::removal_gap_mm;
pub use fit_check::{FitFailure, find_fitting_rotation};
pub use height_bound::lower_bound_mm;
pub use improvement::{ImprovedLayouts, improve_layouts};
pub use insert::insert_copies;
pub use instance::{InstanceError, NestingInstance, NestingItem};
pub use instance_serde::NamedMeshInstance;
pub use lanes::{LaneEnd, LanePlan, LaneTask, finish_lanes, run_lane};
pub use layer_cap::{DEFAULT_LAYER_MM, LayerAreaCap};
pub use layers::LayerAreas;
pub use left_out::{LeftOutFit, examine_left_out};
pub use look_alikes::{LookMeasures, set_look_alikes_apart};
pub use nester::{nest, nest_with_cache};
pub use orientation::OrientationLimits;
pub use orientation_rule::OrientationRule;
#[cfg(feature = "paper")]
pub use paper::PaperConfig;
pub use placement::ItemPlacement;
pub use prepared_meshes::PreparedMeshes;
pub use proof::{
    ClearanceViolation, Disassembly, LayoutProof, LayoutProver, PlacedSolid, find_removal_order, obeys_orientation,
    prove_layout, prove_placed_solids, prove_with_keep_out, prove_with_z_extra,
};
pub use report::{
    ClearanceMeasures, LockedCopy, NestingReport, PackingMeasures, PlacedPart, RemovedCopy, SearchCost, SearchSummary,
    Separability, UnplacedPart,
};
pub use search_budget::SearchBudget;
pub use search_control::{ProgressListener, StopCondition};
pub use solution::NestingSolution;
pub use tilt::{FaceNotDown, MAX_TILTS, TiltLimit, TiltLimitError, write_tilts};

#[cfg(test)]
mod compression_tests;
#[cfg(test)]
mod first_layout_tests;
#[cfg(test)]
mod improvement_tests;
#[cfg(test)]
mod interlock_tests;
#[cfg(test)]
mod nester_tests;
#[cfg(test)]
mod open_build_tests;
#[cfg(test)]
mod precedence_tests;
#[cfg(test)]
mod separation_tests;
#[cfg(test)]
mod tie_break_tests;
