//! The schema on PostgreSQL. The numbers of its migrations are those of SQLite's.

use std::sync::LazyLock;

use sqlx::{
    PgPool,
    migrate::{MigrateError, Migrator},
};

use crate::ledger::{LedgerError, error::Result, schema};

/// Version, description and text of each migration. A ledger here begins with the schema of the first release that had it
/// on PostgreSQL.
const FILES: [(i64, &str, &str); 2] = [
    (19, "ledger", include_str!("../../../migrations/postgres/0019_ledger.sql")),
    (20, "folded names", include_str!("../../../migrations/postgres/0020_folded_names.sql")),
];

static MIGRATIONS: LazyLock<Migrator> = LazyLock::new(|| schema::migrator(&FILES));

/// Applies the missing migrations to a PostgreSQL database. Of two nodes that start at once, one waits for the other.
pub async fn bring_up_to_date(pool: &PgPool) -> Result<()> {
    match MIGRATIONS.run(pool).await {
        Ok(()) => Ok(()),
        Err(MigrateError::VersionMissing(_)) => ensure_current_version(pool).await,
        Err(error) => Err(LedgerError::Migrate { path: "postgres".into(), error }),
    }
}

/// Fails unless the schema of the PostgreSQL database is exactly that of this binary.
pub async fn ensure_current_version(pool: &PgPool) -> Result<()> {
    let is_ledger: bool =
        sqlx::query_scalar("SELECT to_regclass('_sqlx_migrations') IS NOT NULL").fetch_one(pool).await?;
    let found: i64 = match is_ledger {
        false => 0,
        true => sqlx::query_scalar("SELECT coalesce(max(version), 0) FROM _sqlx_migrations").fetch_one(pool).await?,
    };
    schema::compare_versions("postgres".into(), found)
}
