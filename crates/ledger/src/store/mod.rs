//! The ledger itself: a SQLite file or a PostgreSQL server, its schema, its health, and the transaction that every change is.
//!
//! `change` is the only way to write; it looks first whether this process may.

pub(super) mod address;
pub(super) mod change;
pub(super) mod consistency;
pub(super) mod error_class;
pub(super) mod file_guard;
pub(super) mod health;
pub(super) mod last_change;
pub(super) mod ledger;
pub(super) mod location;
pub(crate) mod on_demand;
pub(super) mod postgres;
pub(super) mod schema;
pub(super) mod service;
pub(super) mod sqlite_store;
