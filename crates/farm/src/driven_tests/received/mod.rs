//! What is dropped, ordered and told of a file.

pub(super) mod camspec;
pub(super) mod languages;
pub(super) mod late;
pub(super) mod lists;
pub(super) mod mended;
pub(super) mod orders;
pub(super) mod spoken;
pub(super) mod taken_places;
pub(super) mod tickets;
pub(super) mod unfinished;
pub(super) mod units;
pub(super) mod unordered_files;
pub(super) mod unread_tickets;
