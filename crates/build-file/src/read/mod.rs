//! The door for a file of a part, whatever its format: what it is, whether its writer has ended, and its solids.

pub(super) mod camspec_read;
pub(super) mod file_end;
pub(super) mod part_read;
pub(super) mod sniff;
