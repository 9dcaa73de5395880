//! Who sent a request. Everything else of the pages knows this.

pub(super) mod client;
