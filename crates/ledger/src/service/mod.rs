//! The farm as a whole: machines, nodes, printers, events and who receives them, people and their sessions, status, history, months, costs.

pub(super) mod cost_basis;
pub(super) mod event;
pub(super) mod experience;
pub(super) mod history;
pub(super) mod machine;
pub(super) mod month;
pub(super) mod node;
pub(super) mod person;
pub(super) mod printer;
pub(super) mod receiver;
pub(super) mod session;
pub(super) mod status;
pub(super) mod status_queries;
pub(super) mod totals;
