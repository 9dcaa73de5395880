//! The parts themselves, by the way they are made.

pub(super) mod blocks;
pub(super) mod boulder;
pub(super) mod extruded;
pub(super) mod fan;
pub(super) mod figure;
pub(super) mod revolved;
pub(super) mod swept;
