//! How a part is made by code: outlines that are extruded, swept or revolved, and surfaces of distance functions.

pub(super) mod distance_functions;
pub(super) mod implicit;
pub(super) mod layers;
pub(super) mod marching_tetrahedra;
pub(super) mod outline;
pub(super) mod surface;
pub(super) mod sweep;
pub(super) mod triangulate;
