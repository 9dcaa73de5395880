#![doc = include_str!("../README.md")]
// Bytes <-> meshes: STL, 3MF, OBJ, PLY and CAMSPEC in, build files, thumbnails and pick maps out. Knows meshes and poses, no solutions.

mod build;
mod common;
mod picture;
mod polygons;
mod read;
mod stl;
#[cfg(test)]
mod tests;
mod threemf;

// Their types are in the interface.
pub use {glam, solids};

pub use common::unit::LengthUnit;
pub use picture::picture::{PictureBody, Viewpoint, draw_part, draw_picture, draw_picture_on, kind_colour_code};
pub use picture::shade::PictureScheme;

pub use common::limits::ReadLimits;
pub use common::options::{Arrangement, DeliveryKind};

pub use build::build_file::{
    BuildFile, BuildFileHeading, BuildFileItem, BuildFileObject, BuildFileRules, BuildMetadata, HeadingMetadata,
    OrderWords, PlacedMesh, RulesMetadata,
};
pub use build::build_read::{
    is_model_package, read_build, read_build_and_metadata, read_build_heading, read_build_with_table, read_own_name,
};
pub use build::build_write::write_build;
pub use build::model_write::sanitize_name as name_in_build_file;
pub use build::pick_map::{PickMapRow, pick_rows, write_pick_map};
pub use build::placement_table::write_placement_table;
pub use build::second_reader::cross_check;
pub use build::second_stl_reader::cross_check_stl;
pub use common::camspec::{SolidRequest, is_camspec_name};
pub use common::copies_question::{COPIES_QUESTION, is_copies_question};
pub use common::error::{FileReadError, FileWriteError};
pub use common::file_name::{
    MESH_ENDINGS, MESH_FORMATS, PLACEMENT_TABLE_ENDING, build_file_name, build_file_stem, part_endings,
    placement_table_name,
};
pub use common::part_terms::{
    MAX_CLEARANCE_MM, MAX_COPIES, MAX_PRIORITY, MAX_TEXT_BYTES, check_clearance, check_copies, check_email,
    check_finish, check_name, check_note, check_priority, finish_steps,
};
pub use common::plural::format_count;
pub use common::solid::{PartFileContents, PartFileSolid, SIZE_WARNING};
pub use common::visible_text::{csv_cell, escape_invisible, escape_invisible_lines, is_invisible};
pub use read::file_end::{has_end, may_be_part, may_grow};
pub use read::part_read::read_part_file;
pub use stl::stl_write::write_stl;
pub use threemf::package::declared_entries;
pub use threemf::unpack_guard::{MAX_RATIO, RATIO_FREE_BYTES};
