//! Who serves a folder: markers, leases and the lock of the state folder.
//!
//! Of two farms one is first; a lease that is lost stops all that would write.

pub(super) mod folder_check;
pub(super) mod folder_lease;
pub(super) mod folder_leases;
pub(super) mod known_folders;
pub(super) mod lease_clock;
pub(super) mod lease_holder;
pub(super) mod lease_marker;
pub(super) mod own_machines;
pub(super) mod state_lock;
