//! Geometry x pollination: the packing search. What is asked is an [`Instance`], what is found is a [`Solution`].
//! No clock, no file, no log in here: time comes in through [`Stop`], progress goes out through [`Listener`].

mod body;
mod bound;
mod boxes;
mod cache;
mod compress;
mod config;
mod construct;
mod contest;
mod cut;
mod field;
mod fit;
mod hulls;
mod insert;
mod inside;
mod instance;
mod interlock;
mod layers;
mod layout;
mod locks;
mod near;
mod nester;
mod notes;
mod organs;
mod orientation;
mod outline;
mod paper;
mod piece;
mod proof;
mod push;
mod recipe;
mod relocate;
mod report;
mod reserved;
mod scan;
mod search;
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
pub use cache::Cache;
pub use config::{Config, Interlock, Method, PaperConfig};
pub use fit::{Misfit, fits};
pub use insert::insert;
pub use instance::{BuildVolume, Instance, InstanceError, Item, Margins, OrientationRule};
pub use layers::{DEFAULT_LAYER_MM, LayerAreas, LayerCap};
pub use nester::{nest, nest_with};
pub use organs::Organs;
pub use orientation::Orientation;
pub use proof::{Body, Pair, Proof, TakenApart, prove, prove_raised, prove_with, rotation_obeys, take_apart};
pub use report::{Course, DrawnCopy, NamedCopy, PlacedPart, Report, Separability, UnplacedPart};
pub use search::{Listener, Stop};
pub use separable::drawing_gap_mm;
pub use solution::{Placement, Solution};
pub use tilt::{MAX_TILTS, NotDown, Tilt, TiltError, write_tilts};

#[cfg(test)]
mod goals_tests;
#[cfg(test)]
mod interlock_tests;
#[cfg(test)]
mod nester_tests;
#[cfg(test)]
mod open_tests;
