#![doc = include_str!("../README.md")]
// The packing search: solids x pollination. What is asked is an `Instance`, what is found is a `Solution`. No file, no log and no
// process-wide memory in here: time comes in through `Stop`, progress goes out through `Listener`.

mod body;
mod bound;
mod boxes;
mod build_volume;
mod cache;
mod compress;
mod config;
mod construct;
mod contest;
mod course;
mod cut;
mod field;
mod first_turns;
mod fit;
mod hulls;
mod insert;
mod inside;
mod instance;
mod instance_serde;
mod interlock;
mod layer_cap;
mod layers;
mod layout;
mod locks;
mod near;
mod nester;
mod notes;
mod organs;
mod orientation;
mod orientation_rule;
mod outline;
mod pack;
#[cfg(feature = "paper")]
mod paper;
mod piece;
mod placement;
mod pollination;
mod prepared_meshes;
mod proof;
mod push;
mod recipe;
mod relocate;
mod report;
mod reserved;
mod scan;
mod search;
mod search_budget;
mod separable;
mod separate;
mod settle;
mod shape;
mod skyline;
mod solution;
mod standing;
#[cfg(test)]
mod testing;
mod tilt;
mod touch;
mod turns;
mod voxels;
mod workshop;

pub use bound::lower_bound_mm;
pub use build_volume::{BuildVolume, Margins};
pub use cache::Cache;
pub use config::{Config, Interlock, Method};
pub use fit::{Misfit, fits};
pub use insert::insert;
pub use instance::{Instance, InstanceError, Item};
pub use layer_cap::{DEFAULT_LAYER_MM, LayerCap};
pub use layers::LayerAreas;
pub use nester::{nest, nest_with};
pub use organs::Organs;
pub use orientation::Orientation;
pub use orientation_rule::OrientationRule;
#[cfg(feature = "paper")]
pub use paper::PaperConfig;
pub use placement::Placement;
pub use prepared_meshes::PreparedMeshes;
pub use proof::{
    Body, Pair, Proof, TakenApart, prove, prove_layout, prove_raised, prove_with, rotation_obeys, take_apart,
};
pub use report::{Course, DrawnCopy, NamedCopy, PlacedPart, Report, Separability, UnplacedPart};
pub use search::{Listener, Stop};
pub use search_budget::SearchBudget;
pub use separable::drawing_gap_mm;
pub use solution::Solution;
pub use tilt::{MAX_TILTS, NotDown, Tilt, TiltError, write_tilts};

#[cfg(test)]
mod goals_tests;
#[cfg(test)]
mod interlock_tests;
#[cfg(test)]
mod nester_tests;
#[cfg(test)]
mod open_tests;
