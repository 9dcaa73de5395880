//! The printers of a machine and their queues: which is free, which is down, and what a person has to release.

pub(super) mod printers;
pub(super) mod queue_alerts;
pub(super) mod queues;
pub(super) mod release_preview;
