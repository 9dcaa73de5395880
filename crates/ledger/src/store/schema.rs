//! The schema: migrations embedded in the binary. A released migration is never edited.

use std::{
    path::{Path, PathBuf},
    sync::LazyLock,
};

use sqlx::{
    SqlSafeStr, SqliteConnection, SqlitePool,
    migrate::{MigrateError, Migration, MigrationType, Migrator},
};

use crate::{LedgerError, base::error::Result};

/// Version, description and text of each file of `migrations`; a test compares the two. They are listed, because
/// `sqlx::migrate!`, which reads the folder, has SQLite compiled a second time, for the compiler's own use.
const FILES: &[(i64, &str, &str)] = &[
    (1, "ledger", include_str!("../../../../migrations/0001_ledger.sql")),
    (2, "tilts", include_str!("../../../../migrations/0002_tilts.sql")),
    (3, "a million builds", include_str!("../../../../migrations/0003_a_million_builds.sql")),
    (4, "machines watch", include_str!("../../../../migrations/0004_machines_watch.sql")),
    (5, "messages", include_str!("../../../../migrations/0005_messages.sql")),
    (6, "what came of the search", include_str!("../../../../migrations/0006_what_came_of_the_search.sql")),
    (10, "what bytes are", include_str!("../../../../migrations/0010_what_bytes_are.sql")),
    (12, "attempts of reading", include_str!("../../../../migrations/0012_attempts_of_reading.sql")),
    (13, "decisions", include_str!("../../../../migrations/0013_decisions.sql")),
    (14, "changes are counted", include_str!("../../../../migrations/0014_changes_are_counted.sql")),
    (15, "why refused", include_str!("../../../../migrations/0015_why_refused.sql")),
    (17, "why paused", include_str!("../../../../migrations/0017_why_paused.sql")),
    (18, "orders", include_str!("../../../../migrations/0018_orders.sql")),
    (19, "dates", include_str!("../../../../migrations/0019_dates.sql")),
    (20, "folded names", include_str!("../../../../migrations/0020_folded_names.sql")),
    (22, "nodes", include_str!("../../../../migrations/0022_nodes.sql")),
    (23, "lanes", include_str!("../../../../migrations/0023_lanes.sql")),
    (24, "break out", include_str!("../../../../migrations/0024_break_out.sql")),
    (26, "night search", include_str!("../../../../migrations/0026_night_search.sql")),
    (27, "printers", include_str!("../../../../migrations/0027_printers.sql")),
    (28, "orders by request", include_str!("../../../../migrations/0028_orders_by_request.sql")),
    (29, "withdrawals", include_str!("../../../../migrations/0029_withdrawals.sql")),
    (30, "references", include_str!("../../../../migrations/0030_references.sql")),
    (31, "withdrawn views", include_str!("../../../../migrations/0031_withdrawn_views.sql")),
    (33, "dropped files", include_str!("../../../../migrations/0033_dropped_files.sql")),
    (35, "read again", include_str!("../../../../migrations/0035_read_again.sql")),
    (36, "words on queued builds", include_str!("../../../../migrations/0036_words_on_queued_builds.sql")),
    (37, "overwritten ledgers", include_str!("../../../../migrations/0037_overwritten_ledgers.sql")),
    (38, "dropped words", include_str!("../../../../migrations/0038_dropped_words.sql")),
    (39, "no lanes", include_str!("../../../../migrations/0039_no_lanes.sql")),
    (40, "machine is the word", include_str!("../../../../migrations/0040_machine_is_the_word.sql")),
    (41, "customers", include_str!("../../../../migrations/0041_customers.sql")),
    (42, "material", include_str!("../../../../migrations/0042_material.sql")),
    (43, "profile of machine", include_str!("../../../../migrations/0043_profile_of_machine.sql")),
    (44, "email", include_str!("../../../../migrations/0044_email.sql")),
    (45, "people", include_str!("../../../../migrations/0045_people.sql")),
    (47, "mended meshes", include_str!("../../../../migrations/0047_mended_meshes.sql")),
    (48, "copy of", include_str!("../../../../migrations/0048_copy_of.sql")),
    (49, "lots", include_str!("../../../../migrations/0049_lots.sql")),
    (50, "finishing", include_str!("../../../../migrations/0050_finishing.sql")),
    (51, "one farm", include_str!("../../../../migrations/0051_one_farm.sql")),
    (52, "documents", include_str!("../../../../migrations/0052_documents.sql")),
];

pub(crate) static MIGRATIONS: LazyLock<Migrator> = LazyLock::new(|| migrator(FILES));

/// The migrations of a list of files.
pub(crate) fn migrator(files: &[(i64, &'static str, &'static str)]) -> Migrator {
    let migration = |&(version, description, text): &(i64, &'static str, &'static str)| {
        Migration::new(version, description.into(), MigrationType::Simple, text.into_sql_str(), false)
    };
    Migrator::with_migrations(files.iter().map(migration).collect())
}

/// Applies the missing migrations, all or none. If two daemons start at once, the second waits for the first and finds
/// nothing to do.
pub async fn bring_up_to_date(path: &Path, writer: &SqlitePool) -> Result<()> {
    let mut transaction = writer.begin_with("BEGIN IMMEDIATE").await?;
    super::health::remove_checksum(path).map_err(|source| LedgerError::Folder { path: path.to_owned(), source })?;
    let applied = MIGRATIONS.run_direct(None, &mut *transaction, false).await;
    match applied {
        Ok(()) => {
            fold_order_names(&mut transaction).await?;
            Ok(transaction.commit().await?)
        }
        Err(MigrateError::VersionMissing(_)) => {
            drop(transaction);
            ensure_current_version(path, writer).await
        }
        Err(error) => Err(LedgerError::Migrate { path: path.to_owned(), error }),
    }
}

/// Folds the names of orders that migration 20 left to this, because SQLite knows the letter case of ASCII only.
async fn fold_order_names(db: &mut SqliteConnection) -> Result<()> {
    let names: Vec<String> =
        sqlx::query_scalar("SELECT name FROM customer_order WHERE folded = ''").fetch_all(&mut *db).await?;
    for name in names {
        let fold = sqlx::query("UPDATE customer_order SET folded = $1 WHERE name = $2").bind(name.to_lowercase());
        fold.bind(&name).execute(&mut *db).await?;
    }
    Ok(())
}

/// Fails unless the schema is exactly that of this binary.
pub async fn ensure_current_version(path: &Path, writer: &SqlitePool) -> Result<()> {
    let failed = |error| LedgerError::Open { path: path.to_owned(), error };
    let is_ledger = "SELECT count(*) FROM sqlite_schema WHERE name = '_sqlx_migrations'";
    let found: i64 = match sqlx::query_scalar::<_, i64>(is_ledger).fetch_one(writer).await.map_err(failed)? {
        0 => 0,
        _ => sqlx::query_scalar("SELECT coalesce(max(version), 0) FROM _sqlx_migrations")
            .fetch_one(writer)
            .await
            .map_err(failed)?,
    };
    compare_versions(path.to_owned(), found, MIGRATIONS.iter().map(|m| m.version).max().unwrap_or(0))
}

/// Fails unless `found` is `known`, the newest version that this binary knows.
pub(super) fn compare_versions(path: PathBuf, found: i64, known: i64) -> Result<()> {
    match found.cmp(&known) {
        std::cmp::Ordering::Less => Err(LedgerError::OlderSchema { path, found, known }),
        std::cmp::Ordering::Equal => Ok(()),
        std::cmp::Ordering::Greater => Err(LedgerError::NewerSchema { path, found, known }),
    }
}
