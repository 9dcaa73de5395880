#![doc = include_str!("../README.md")]
// Bytes <-> meshes: STL and 3MF in, build files, thumbnails and pick maps out. Knows meshes and poses, no solutions.

mod lettering;
mod picture;
mod raster;
mod shade;
mod unit;

pub use picture::{Drawn, Viewpoint, picture};
pub use unit::Unit;

mod limits;
mod options;

pub use limits::Limits;
pub use options::{Arrangement, Instances};

mod build_file;
mod build_read;
mod build_write;
mod counted;
mod document;
mod error;
mod file_end;
mod file_name;
mod flatten;
mod guard;
mod model;
mod model_parse;
mod model_write;
mod number;
mod package;
mod pick_map;
mod read;
mod second_reader;
mod sniff;
mod solid;
mod stl_read;
mod stl_text;
mod stl_write;
mod threemf_read;
mod uuid;
mod visible;
mod xml;

pub use build_file::{BuildFile, BuildInfo, BuildItem, BuildObject, PlacedMesh};
pub use build_read::{read_build, read_build_and_info};
pub use build_write::write_build;
pub use counted::counted;
pub use error::{ReadError, WriteError};
pub use file_end::{has_end, may_be_part};
pub use file_name::build_file_name;
pub use model_write::safe as name_in_build_file;
pub use pick_map::{PickRow, pick_rows, write_pick_map};
pub use read::read;
pub use second_reader::cross_check;
pub use solid::{Contents, Solid};
pub use stl_write::write_stl;
pub use visible::{cell, is_invisible, visible, visible_lines};

#[cfg(test)]
mod build_tests;
