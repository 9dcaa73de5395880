//! Exact answers about two solids in their poses: how far apart, where they touch, how far one may slide.
//!
//! The search and the independent proof share these answers; they are exact on the triangles.

pub(super) mod clearance;
pub(super) mod contact;
pub(super) mod direction_sweep;
pub(super) mod sliding_distance;
