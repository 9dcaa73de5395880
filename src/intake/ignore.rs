//! Names that are nobody's part: temporary files of copiers, editors and browsers, and folders of systems.

use std::ffi::OsStr;

/// Whether a file or folder of this name is passed over, at any depth.
pub fn is_ignored(name: &OsStr) -> bool {
    name.as_encoded_bytes().starts_with(b".")
}
