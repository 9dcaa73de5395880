//! Geometry x pollination: the packing search. What is asked is an [`Instance`], what is found is a [`Solution`].
//! No clock, no file, no log in here: time comes in through [`Stop`], progress goes out through [`Listener`].

mod bound;
mod config;
mod instance;
mod nester;
mod paper;
mod proof;
mod rotations;
mod search;
mod solution;

pub use bound::lower_bound_mm;
pub use config::{Config, Method, PaperConfig};
pub use instance::{BuildVolume, Instance, InstanceError, Item, OrientationRule};
pub use nester::nest;
pub use proof::{Body, Pair, Proof, prove, rotation_obeys};
pub use search::{Listener, Stop};
pub use solution::{Placement, Solution};
