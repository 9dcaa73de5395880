//! Files of parts are read, also in a child process, and read again in the same unit and size; meshes are kept; refused files lie with their reasons.

pub(super) mod claim_note;
pub(super) mod disk_cache;
pub(super) mod error_folder;
pub(super) mod file_fault;
pub(super) mod isolated_read;
pub(super) mod judged_file;
pub(super) mod mending;
pub(super) mod mesh_cache;
pub(super) mod mesh_source;
pub(super) mod read;
pub(super) mod read_again;
pub(super) mod read_turn;
pub(super) mod refused_files;
pub(super) mod standing_claim;
