//! What is wanted of a file: by its ticket, the list of its folder and its name, also when they come late.

pub(super) mod late_ticket;
pub(super) mod list_end;
pub(super) mod list_tracker;
pub(super) mod other_lists;
pub(super) mod part_spec;
