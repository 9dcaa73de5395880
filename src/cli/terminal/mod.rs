//! What all commands share: arguments, how a table is printed, and how what a person names is found.
//!
//! No command is here, and nothing here changes a farm.

pub(super) mod atomic_file;
pub(super) mod build_lookup;
pub(super) mod candidates;
pub(super) mod common;
pub(super) mod expected_parts;
pub(super) mod farm_context;
pub(super) mod logging;
pub(super) mod lookup;
pub(super) mod show_text;
pub(super) mod table;
pub(super) mod target;
pub(super) mod terminal;
pub(super) mod values;
pub(super) mod watch;
