//! 3MF as customers and slicers send it: the package, its XML, the model, and what a project of a slicer says of each object.
//!
//! Every step is within `limits`; nothing is unpacked before it is counted.

pub(super) mod document;
pub(super) mod flatten;
pub(super) mod item_contact;
pub(super) mod model;
pub(super) mod model_head;
pub(super) mod model_parse;
pub(super) mod package;
mod plain_lists;
pub(super) mod slicer_project;
pub(super) mod threemf_read;
pub(super) mod unpack_guard;
pub(super) mod xml;
pub(super) mod xml_names;
