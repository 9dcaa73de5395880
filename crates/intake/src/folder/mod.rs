//! What lies in a hot folder and in the store: entries and their roles, what is ignored, claims and their notes.
//!
//! Knows names and places of files; it decides nothing about a part.

pub(super) mod claim_folder;
pub(super) mod claim_notes;
pub(super) mod claimed_part;
pub(super) mod control_file;
pub(super) mod disk;
pub(super) mod emptied_folders;
pub(super) mod file_role;
pub(super) mod ignore;
pub(super) mod inbox_entry;
pub(super) mod misplaced;
pub(super) mod order_folders;
pub(super) mod status;
pub(super) mod store;
pub(super) mod watch;
