//! A claimed file becomes a part: recorded, read, asked about, refused; the jobs that scan (`scanning` claims) and what follows them.

pub(super) mod claim_completion;
pub(super) mod control_files;
pub(super) mod damaged_files;
pub(super) mod deferred_refusal;
pub(super) mod doubtful_drops;
pub(super) mod duplicates;
pub(super) mod forget;
pub(super) mod hurried_scans;
pub(super) mod intake_jobs;
pub(super) mod late_tickets;
pub(super) mod mark_note;
pub(super) mod missing_files;
pub(super) mod refused_part;
pub(super) mod scan_jobs;
