//! Geometry x pollination: the packing search. What is asked is an [`Instance`], what is found is a [`Solution`].
//! No clock, no file, no log in here: time comes in through [`Stop`], progress goes out through [`Listener`].

mod body;
mod bound;
mod compress;
mod config;
mod construct;
mod field;
mod fit;
mod inside;
mod instance;
mod layout;
mod nester;
mod orientation;
mod paper;
mod piece;
mod proof;
mod push;
mod relocate;
mod report;
mod search;
mod separate;
mod shape;
mod skyline;
mod solution;
#[cfg(test)]
mod testing;
mod tilt;
mod touch;
mod turns;
mod voxels;

pub use bound::lower_bound_mm;
pub use config::{Config, Method, PaperConfig};
pub use fit::{Misfit, fits};
pub use instance::{BuildVolume, Instance, InstanceError, Item, Margins, OrientationRule};
pub use nester::nest;
pub use orientation::Orientation;
pub use proof::{Body, Pair, Proof, prove, prove_raised, rotation_obeys};
pub use report::{Course, PlacedPart, Report, UnplacedPart};
pub use search::{Listener, Stop};
pub use solution::{Placement, Solution};
pub use tilt::{MAX_TILTS, NotDown, Tilt, TiltError, write_tilts};

#[cfg(test)]
mod nester_tests;
