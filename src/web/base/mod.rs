//! What every page and answer is made of: the frame of a page, errors, formats, lists, clients and limits.

pub(super) mod api_body;
pub(super) mod assets;
pub(super) mod cache;
pub(super) mod client_gate;
pub(super) mod client_limits;
pub(super) mod compressed;
pub(super) mod connection_limits;
pub(super) mod error;
pub(super) mod form_field;
pub(super) mod format;
pub(super) mod listener;
pub(super) mod listing;
pub(super) mod page;
pub(super) mod query;
