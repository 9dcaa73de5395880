//! For tests of the ledger and of what stands above it: ledgers in separate folders, parts, builds, and a private PostgreSQL server.
//!
//! The tests of `ledger` itself include these files, because they need the types of the crate under test.

#![allow(clippy::unwrap_used, reason = "a test ends where a fixture cannot be made")]
#![allow(missing_docs, reason = "the names say it")]

mod above;
mod ledgers;
pub mod postgres_cluster;
pub mod server_link;

pub use above::{ToldWords, part_row};
pub use ledgers::*;
