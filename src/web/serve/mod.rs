//! Who may ask, and the server: roles, the guard, what is passed on to other nodes, forms that are carried out once, all addresses.

pub(super) mod asset_route;
pub(super) mod drop;
pub(super) mod guard;
pub(super) mod metrics;
pub(super) mod page_routes;
mod pass_on;
pub(super) mod role_rules;
pub(super) mod sent_form;
pub(super) mod server;
mod spoken;
