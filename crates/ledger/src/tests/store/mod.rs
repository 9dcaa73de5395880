//! The file or server itself: its schema and upgrades, its copies, the plans of its queries, random walks over all changes.

pub(super) mod backup;
pub(super) mod migrations;
pub(super) mod opening;
pub(super) mod precedence;
pub(super) mod queries;
pub(super) mod query_plans;
pub(super) mod random_walks;
pub(super) mod shapes;
pub(super) mod upgrade;
