//! Parts that are wanted again or otherwise: changes, revisions, questions, originals from the archive, second copies of files.

pub(super) mod fetch_originals;
pub(super) mod part_changes;
pub(super) mod part_questions;
pub(super) mod revisions;
pub(super) mod second_copies;
