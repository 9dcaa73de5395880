//! How a part may be turned: the rules of an order and the rotations that obey them.
//!
//! Owns rotations alone; it knows no parts, no layouts and no search.

pub(super) mod first_rotations;
pub(super) mod orientation;
pub(super) mod orientation_rule;
pub(super) mod rotations;
pub(super) mod tilt;
