//! A part as the search sees it: points, spheres, a distance field, an outline.
//!
//! Made once for each mesh and shared by all copies and all searches (`cache`). Nothing here knows where a part lies.

pub(super) mod bounding_sphere;
pub(super) mod byte_codec;
pub(super) mod cache;
pub(super) mod distance_field;
pub(super) mod outline;
pub(super) mod part_raster;
pub(super) mod point_block;
pub(super) mod shape;
pub(super) mod skyline;
pub(super) mod solid_nodes;
pub(super) mod sphere_tree;
pub(super) mod sphere_walk;
