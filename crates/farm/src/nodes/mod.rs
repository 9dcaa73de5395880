//! Machines that come, go and are adopted: leases renewed, folders compared, watches set.

pub(super) mod adopt;
pub(super) mod folder_comparison;
pub(super) mod lease_renewal;
pub(super) mod machine_availability;
pub(super) mod watching;
