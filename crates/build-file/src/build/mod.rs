//! The build file that a printer gets: written, read back, read by a second reader that shares no code, and its pick map.

pub(super) mod build_file;
pub(super) mod build_read;
pub(super) mod build_write;
pub(super) mod model_write;
pub(super) mod pick_map;
pub(super) mod second_reader;
