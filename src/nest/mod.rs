//! Geometry x pollination: the packing search. What is asked is an [`Instance`], what is found is a [`Solution`].
//! No clock, no file, no log in here: time comes in through [`Stop`], progress goes out through [`Listener`].

mod body;
mod bound;
mod compress;
mod config;
mod construct;
mod field;
mod fit;
mod hulls;
mod inside;
mod instance;
mod interlock;
mod layout;
mod locks;
mod nester;
mod paper;
mod piece;
mod proof;
mod push;
mod relocate;
mod report;
mod search;
mod separable;
mod separate;
mod shape;
mod skyline;
mod solution;
#[cfg(test)]
mod testing;
mod touch;
mod turns;
mod voxels;

pub use bound::lower_bound_mm;
pub use config::{Config, Interlock, Method, PaperConfig};
pub use fit::{Misfit, fits};
pub use instance::{BuildVolume, Instance, InstanceError, Item, OrientationRule};
pub use nester::nest;
pub use proof::{Body, Pair, Proof, TakenApart, prove, rotation_obeys, take_apart};
pub use report::{Course, DrawnCopy, NamedCopy, PlacedPart, Report, Separability, UnplacedPart};
pub use search::{Listener, Stop};
pub use separable::drawing_gap_mm;
pub use solution::{Placement, Solution};

#[cfg(test)]
mod interlock_tests;
#[cfg(test)]
mod nester_tests;
