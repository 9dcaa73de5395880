//! A scan, the decision that a file has settled, and its claim by rename; what was claimed is found again after a crash, refused or given back.
//!
//! No file is lost here: each is in the hot folder, a claim, the store or the error folder.

pub(super) mod adopt;
pub(super) mod archive;
pub(super) mod claim;
pub(super) mod dropped;
pub(super) mod given_back;
pub(super) mod late_writing;
pub(super) mod recover;
pub(super) mod refuse;
pub(super) mod scan;
pub(super) mod settle;
pub(super) mod settled_entry;
pub(super) mod unpack;
