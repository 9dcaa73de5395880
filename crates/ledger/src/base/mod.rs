//! What every row is made of: one SQL for two databases, errors, ids, times and the states with their moves.
//!
//! Asks no database.

pub(super) mod close_order_error;
pub(super) mod error;
pub(super) mod event_kind;
pub(super) mod id;
pub(super) mod in_queue_error;
pub(super) mod lock_wait;
pub(super) mod material_error;
pub(super) mod name_pattern;
pub(super) mod refusal_cause;
pub(super) mod server_error;
pub(super) mod sql;
pub(super) mod sqlite_code;
pub(super) mod state;
pub(super) mod text_column;
pub(super) mod time;
