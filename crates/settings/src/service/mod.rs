//! Settings of the daemon itself: folders, log, pages, metrics, notifications, nodes.

pub(super) mod email;
pub(super) mod folders;
pub(super) mod inputs;
pub(super) mod logging;
pub(super) mod metrics;
pub(super) mod node;
pub(super) mod notify;
pub(super) mod settings;
pub(super) mod web;
