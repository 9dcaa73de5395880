//! The schema on PostgreSQL. The numbers of its migrations are those of SQLite's.

use std::sync::LazyLock;

use sqlx::{
    PgPool,
    migrate::{MigrateError, Migrator},
};

use crate::ledger::{LedgerError, ServerError, error::Result, schema};

/// Version, description and text of each migration. A ledger here begins with the schema of the first release that had it
/// on PostgreSQL.
const FILES: [(i64, &str, &str); 6] = [
    (19, "ledger", include_str!("../../../migrations/postgres/0019_ledger.sql")),
    (20, "folded names", include_str!("../../../migrations/postgres/0020_folded_names.sql")),
    (21, "lease", include_str!("../../../migrations/postgres/0021_lease.sql")),
    (22, "nodes", include_str!("../../../migrations/postgres/0022_nodes.sql")),
    (23, "lanes", include_str!("../../../migrations/postgres/0023_lanes.sql")),
    (24, "break out", include_str!("../../../migrations/postgres/0024_break_out.sql")),
];

static MIGRATIONS: LazyLock<Migrator> = LazyLock::new(|| schema::migrator(&FILES));

/// Applies the missing migrations to a PostgreSQL database. Of two nodes that start at once, one waits for the other.
pub async fn bring_up_to_date(pool: &PgPool, label: &str) -> Result<()> {
    if ensure_current_version(pool, label).await.is_ok() {
        return Ok(());
    }
    match MIGRATIONS.run(pool).await {
        Ok(()) => Ok(()),
        Err(MigrateError::VersionMissing(_)) => ensure_current_version(pool, label).await,
        Err(error) => Err(LedgerError::Migrate { path: label.into(), error }),
    }
}

/// Fails unless the schema of the PostgreSQL database is exactly that of this binary.
pub async fn ensure_current_version(pool: &PgPool, label: &str) -> Result<()> {
    let found = match has_table(pool, "_sqlx_migrations").await? {
        false => 0,
        true => {
            let newest = sqlx::query_scalar("SELECT coalesce(max(version), 0) FROM _sqlx_migrations");
            newest.fetch_one(pool).await.map_err(ServerError::mark_unreachable)?
        }
    };
    schema::compare_versions(label.into(), found, &MIGRATIONS)
}

/// Whether the database has a table with this name.
pub async fn has_table(pool: &PgPool, name: &str) -> Result<bool> {
    let found = sqlx::query_scalar("SELECT to_regclass($1) IS NOT NULL").bind(name).fetch_one(pool).await;
    Ok(found.map_err(ServerError::mark_unreachable)?)
}
