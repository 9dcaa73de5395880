//! From an instance to what a search works on: the shapes of all items, their volumes and the areas of layers.
//!
//! It is the last step that reads triangles; a search only moves what is prepared.

pub(super) mod height_bound;
pub(super) mod layers;
pub(super) mod preparation;
pub(super) mod prepared_instance;
pub(super) mod prepared_meshes;
