//! The ledger on PostgreSQL. Its statements are those of the other files of the ledger; here are its connections, its
//! schema, and a server for tests.

mod change_lock;
mod connections;
mod lease;
#[cfg(test)]
mod lease_interleavings;
mod lease_watch;
mod notices;
mod repair_due;
mod schema;
mod shared_farm;
mod store;
mod time_limits;

pub(crate) use lease::{CountedChange, revoke_lapsed};
pub(crate) use notices::{ChangeNotices, notify};
pub(crate) use store::PostgresStore;

/// Starts a newer nestd, whose schema has more migrations, as far as that changes the ledger.
#[cfg(test)]
pub(crate) async fn upgrade_as_newer(
    server: &crate::ServerAddress,
    added: &[(i64, &'static str, bool)],
) -> crate::base::error::Result<()> {
    let pool = sqlx::PgPool::connect_with(server.connect_options()?).await?;
    schema::ServerSchema::newer(added).bring_up_to_date(&pool, "the ledger", "newer").await
}
