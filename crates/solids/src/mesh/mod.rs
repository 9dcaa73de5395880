//! A part's triangles: points, bounds and poses, the mesh, its connected shells, and what is wrong with it.
//!
//! Decides which triangles are one solid. Measures no distance.

pub(super) mod bounds;
pub(super) mod defects;
pub(super) mod eigen;
pub(super) mod equal_pieces;
pub(super) mod local_order;
pub(super) mod mesh;
pub(super) mod mesh_builder;
pub(super) mod mesh_serde;
pub(super) mod pose;
pub(super) mod shells;
pub(super) mod simple_solids;
pub(super) mod triangle;
pub(super) mod weld;
