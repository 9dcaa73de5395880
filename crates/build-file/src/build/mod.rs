//! The build file that a printer gets: written, read back, read by a second reader that shares no code, and its pick map.
//!
//! `build_write` and `build_read` are the doors for every kind of delivery: a 3MF (`model_write`), a whole build as STL (`stl_build`), and a
//! package of STL files (`parts_build`). All of them hold what is needed to tell which copy stands where; of a whole build as STL, a
//! table beside it does (`placement_table`).

pub(super) mod build_file;
mod build_metadata;
pub(super) mod build_read;
pub(super) mod build_write;
mod mesh_lists;
pub(super) mod model_write;
mod new_build;
mod package_entry;
mod parts_build;
pub(super) mod pick_map;
pub(super) mod placement_table;
pub(super) mod second_reader;
pub(super) mod second_stl_reader;
mod stl_build;
