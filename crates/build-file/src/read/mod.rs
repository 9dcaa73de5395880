//! The door for a file of a part, whatever its format: what it is, whether its writer has ended, and its solids.
//!
//! A new format has a reader beside `polygons` or `stl`, a variant and its marks in `sniff`, its end in `file_end`, a call in `part_read`, and its
//! ending in `common/file_name`. Hot folders, forms and order lists take it by that ending.

pub(super) mod camspec_read;
pub(super) mod file_end;
pub(super) mod part_read;
pub(super) mod sniff;
