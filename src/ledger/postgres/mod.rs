//! The ledger on PostgreSQL. Its statements are those of the other files of the ledger; here are its connections, its
//! schema, and a server for tests.

mod change_lock;
#[cfg(test)]
pub(super) mod cluster;
mod lease;
#[cfg(test)]
mod lease_interleavings;
mod lease_watch;
mod schema;
mod store;

pub(super) use lease::revoke_lapsed;
pub(super) use store::PostgresStore;
