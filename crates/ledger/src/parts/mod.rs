//! Parts: claimed, read, waiting, changed, asked about.

pub(super) mod claim;
pub(super) mod due_dates;
pub(super) mod edit;
pub(super) mod late_ticket;
pub(super) mod material;
pub(super) mod missing_file;
pub(super) mod part;
pub(super) mod part_edit;
pub(super) mod part_list;
pub(super) mod part_question;
pub(super) mod part_size;
pub(super) mod revision;
pub(super) mod taken_back;
pub(super) mod waiting;
