//! STL, binary and text.

pub(super) mod stl_read;
pub(super) mod stl_text;
pub(super) mod stl_write;
