//! Orders: of customers, and of programs with their keys.

pub(super) mod customer_order;
pub(super) mod name_search;
pub(super) mod order_line;
pub(super) mod order_request;
pub(super) mod request_key;
