//! The ledger on PostgreSQL. Its statements are those of the other files of the ledger; here are its connections, its
//! schema, and a server for tests.

mod change_lock;
#[cfg(test)]
pub(super) mod cluster;
mod lease;
#[cfg(test)]
mod lease_interleavings;
mod lease_watch;
mod repair_due;
mod schema;
#[cfg(test)]
pub(super) mod server_link;
mod shared_farm;
mod store;
mod time_limits;

pub(super) use lease::{CountedChange, revoke_lapsed};
pub(super) use store::PostgresStore;

/// Starts a newer nestd, whose schema has more migrations, as far as that changes the ledger.
#[cfg(test)]
pub(super) async fn upgrade_as_newer(
    server: &super::ServerAddress,
    added: &[(i64, &'static str, bool)],
) -> super::error::Result<()> {
    let pool = sqlx::PgPool::connect_with(server.connect_options()?).await?;
    schema::ServerSchema::newer(added).bring_up_to_date(&pool, "the ledger", "newer").await
}
