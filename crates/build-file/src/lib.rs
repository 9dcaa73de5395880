#![doc = include_str!("../README.md")]
// Bytes <-> meshes: STL and 3MF in, build files, thumbnails and pick maps out. Knows meshes and poses, no solutions.

mod lettering;
mod picture;
mod raster;
mod shade;
mod unit;

pub use picture::{PictureBody, Viewpoint, draw_part, draw_picture, draw_picture_on, kind_colour_code};
pub use shade::PictureScheme;
pub use unit::LengthUnit;

mod limits;
mod options;

pub use limits::ReadLimits;
pub use options::{Arrangement, InstanceSharing};

mod build_file;
mod build_read;
mod build_write;
mod camspec;
mod camspec_read;
mod decimal;
mod document;
mod error;
mod file_end;
mod file_name;
mod flatten;
mod item_contact;
mod model;
mod model_parse;
mod model_write;
mod package;
mod part_read;
mod pick_map;
mod plural;
mod second_reader;
mod slicer_project;
mod sniff;
mod solid;
mod stl_read;
mod stl_text;
mod stl_write;
mod threemf_read;
mod unfinished;
mod unpack_guard;
mod uuid;
mod visible_text;
mod xml;
mod xml_names;

pub use build_file::{
    BuildFile, BuildFileHeading, BuildFileItem, BuildFileObject, BuildFileRules, BuildMetadata, HeadingMetadata,
    OrderWords, PlacedMesh, RulesMetadata,
};
pub use build_read::{read_build, read_build_and_metadata};
pub use build_write::write_build;
pub use camspec::{MAX_CLEARANCE_MM, SolidRequest, is_camspec_name};
pub use error::{FileReadError, FileWriteError};
pub use file_end::{has_end, may_be_part, may_grow};
pub use file_name::build_file_name;
pub use model_write::sanitize_name as name_in_build_file;
pub use part_read::read_part_file;
pub use pick_map::{PickMapRow, pick_rows, write_pick_map};
pub use plural::format_count;
pub use second_reader::cross_check;
pub use solid::{PartFileContents, PartFileSolid};
pub use stl_write::write_stl;
pub use visible_text::{csv_cell, escape_invisible, escape_invisible_lines, is_invisible};

#[cfg(test)]
mod build_tests;
#[cfg(test)]
mod camspec_tests;
#[cfg(test)]
mod item_contact_tests;
#[cfg(test)]
mod slicer_project_tests;
#[cfg(test)]
mod test_package;
#[cfg(test)]
mod unfinished_tests;
