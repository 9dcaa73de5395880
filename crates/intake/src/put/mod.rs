//! Files that do not come through the hot folder: those of pages and of programs.

pub(super) mod ordered_claim;
pub(super) mod put_content;
pub(super) mod put_upload;
pub(super) mod upload;
