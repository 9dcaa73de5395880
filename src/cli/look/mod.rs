//! Commands that show something and change nothing.

pub(super) mod costs;
pub(super) mod history;
pub(super) mod metrics;
pub(super) mod nodes;
pub(super) mod orders;
pub(super) mod plan;
pub(super) mod quote;
pub(super) mod render;
pub(super) mod report;
pub(super) mod show;
pub(super) mod status;
