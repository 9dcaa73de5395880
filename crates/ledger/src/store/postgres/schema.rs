//! The schema on PostgreSQL. The numbers of its migrations are those of SQLite's.
//!
//! Nodes are upgraded one after the other. A migration that only adds what an older nestd need not know (a table, a column with a
//! default, an index) is applied while older nodes run; they go on, and start again, until their turn comes. Any other one is refused
//! until the older nodes have ended.

use std::sync::LazyLock;

use sqlx::{
    AssertSqlSafe, PgConnection, PgPool,
    migrate::{MigrateError, Migrator},
};

use super::{change_lock::begin_locked, time_limits::ConnectionUser};
use crate::{
    LedgerError, ServerError,
    base::{
        error::Result,
        sql::{allow_whole_ledger, answered_within},
    },
    store::schema,
};

/// A change of the schema.
pub(super) struct ServerMigration {
    version: i64,
    description: &'static str,
    text: &'static str,
    /// Whether a nestd that does not know it can use the ledger.
    is_additive: bool,
}

const fn migration(version: i64, description: &'static str, text: &'static str) -> ServerMigration {
    ServerMigration { version, description, text, is_additive: false }
}

/// All migrations. A ledger here begins with the schema of the first release that had it on PostgreSQL.
const MIGRATIONS: [ServerMigration; 30] = [
    migration(19, "ledger", include_str!("../../../../../migrations/postgres/0019_ledger.sql")),
    migration(20, "folded names", include_str!("../../../../../migrations/postgres/0020_folded_names.sql")),
    migration(21, "lease", include_str!("../../../../../migrations/postgres/0021_lease.sql")),
    migration(22, "nodes", include_str!("../../../../../migrations/postgres/0022_nodes.sql")),
    migration(23, "lanes", include_str!("../../../../../migrations/postgres/0023_lanes.sql")),
    migration(24, "break out", include_str!("../../../../../migrations/postgres/0024_break_out.sql")),
    migration(
        25,
        "failovers and upgrades",
        include_str!("../../../../../migrations/postgres/0025_failovers_and_upgrades.sql"),
    ),
    ServerMigration {
        is_additive: true,
        ..migration(26, "night search", include_str!("../../../../../migrations/postgres/0026_night_search.sql"))
    },
    ServerMigration {
        is_additive: true,
        ..migration(27, "printers", include_str!("../../../../../migrations/postgres/0027_printers.sql"))
    },
    ServerMigration {
        is_additive: true,
        ..migration(
            28,
            "orders by request",
            include_str!("../../../../../migrations/postgres/0028_orders_by_request.sql"),
        )
    },
    ServerMigration {
        is_additive: true,
        ..migration(29, "withdrawals", include_str!("../../../../../migrations/postgres/0029_withdrawals.sql"))
    },
    ServerMigration {
        is_additive: true,
        ..migration(30, "references", include_str!("../../../../../migrations/postgres/0030_references.sql"))
    },
    ServerMigration {
        is_additive: true,
        ..migration(31, "withdrawn views", include_str!("../../../../../migrations/postgres/0031_withdrawn_views.sql"))
    },
    ServerMigration {
        is_additive: true,
        ..migration(33, "dropped files", include_str!("../../../../../migrations/postgres/0033_dropped_files.sql"))
    },
    ServerMigration {
        is_additive: true,
        ..migration(35, "read again", include_str!("../../../../../migrations/postgres/0035_read_again.sql"))
    },
    // An older node would carry out no word: it would have the copies wait again.
    migration(
        36,
        "words on queued builds",
        include_str!("../../../../../migrations/postgres/0036_words_on_queued_builds.sql"),
    ),
    ServerMigration {
        is_additive: true,
        ..migration(38, "dropped words", include_str!("../../../../../migrations/postgres/0038_dropped_words.sql"))
    },
    // An older node uses what is dropped.
    migration(39, "no lanes", include_str!("../../../../../migrations/postgres/0039_no_lanes.sql")),
    migration(
        40,
        "machine is the word",
        include_str!("../../../../../migrations/postgres/0040_machine_is_the_word.sql"),
    ),
    migration(41, "customers", include_str!("../../../../../migrations/postgres/0041_customers.sql")),
    // An older node would put all materials into one build.
    migration(42, "material", include_str!("../../../../../migrations/postgres/0042_material.sql")),
    migration(43, "profile of machine", include_str!("../../../../../migrations/postgres/0043_profile_of_machine.sql")),
    migration(44, "email", include_str!("../../../../../migrations/postgres/0044_email.sql")),
    // An older node would ask nobody who he is.
    migration(45, "people", include_str!("../../../../../migrations/postgres/0045_people.sql")),
    // An older node would print the mesh as it was dropped.
    migration(47, "mended meshes", include_str!("../../../../../migrations/postgres/0047_mended_meshes.sql")),
    migration(48, "copy of", include_str!("../../../../../migrations/postgres/0048_copy_of.sql")),
    migration(49, "lots", include_str!("../../../../../migrations/postgres/0049_lots.sql")),
    migration(50, "finishing", include_str!("../../../../../migrations/postgres/0050_finishing.sql")),
    ServerMigration {
        is_additive: true,
        ..migration(51, "one farm", include_str!("../../../../../migrations/postgres/0051_one_farm.sql"))
    },
    // An older node does not know why a document or a missing file is refused.
    migration(52, "documents", include_str!("../../../../../migrations/postgres/0052_documents.sql")),
];

/// The first schema whose nestd states what it knows, and compares it.
const FIRST_WITH_RANGE: i64 = 25;

/// How long a migration waits for a reader, such as `pg_dump`, while others wait for the migration.
const LOCK_TIMEOUT: &str = "SET LOCAL lock_timeout = '10s'";

/// The schema that a nestd brings.
pub(super) struct ServerSchema {
    migrator: Migrator,
    /// The newest version.
    newest: i64,
    /// The oldest version whose nestd can use a ledger with the newest one.
    usable_from: i64,
}

/// The schema of this binary.
pub(super) static SCHEMA: LazyLock<ServerSchema> = LazyLock::new(|| ServerSchema::of(&MIGRATIONS));

impl ServerSchema {
    fn of(migrations: &[ServerMigration]) -> Self {
        let files: Vec<_> = migrations.iter().map(|m| (m.version, m.description, m.text)).collect();
        let migrator = Migrator { locking: false, ..schema::migrator(&files) };
        let newest = |of: &dyn Fn(&&ServerMigration) -> bool| migrations.iter().filter(of).map(|m| m.version).max();
        Self {
            migrator,
            newest: newest(&|_| true).unwrap_or_default(),
            usable_from: newest(&|m| !m.is_additive).unwrap_or_default(),
        }
    }

    /// The newest version.
    pub(super) fn newest(&self) -> i64 {
        self.newest
    }

    /// Applies the missing migrations, all or none, if the nodes that run can use the ledger afterwards. `owner` = who asks. Of two that
    /// start at once, one waits for the other.
    ///
    /// `ServedByOther` or `OlderNodes`.
    pub(super) async fn bring_up_to_date(&self, pool: &PgPool, label: &str, owner: &str) -> Result<()> {
        if self.ensure_usable(pool, label).await.is_ok() {
            return Ok(());
        }
        let mut transaction = begin_locked(pool).await?;
        let found = newest_version(&mut transaction).await?;
        if found >= self.newest {
            drop(transaction);
            return self.ensure_usable(pool, label).await;
        }
        self.ensure_no_older_node(&mut transaction, found, owner).await?;
        allow_whole_ledger(&mut transaction).await?;
        sqlx::query(LOCK_TIMEOUT).execute(&mut *transaction).await.map_err(ServerError::mark_unreachable)?;
        let applied = self.migrator.run_direct(None, &mut *transaction, false).await;
        applied.map_err(|error| name_cause(error, label))?;
        let range = sqlx::query("UPDATE schema_range SET usable_from = greatest(usable_from, $1)");
        range.bind(self.usable_from).execute(&mut *transaction).await.map_err(ServerError::mark_unreachable)?;
        // An older node that slept meanwhile is fenced off.
        let fence = sqlx::query("UPDATE lease SET epoch = epoch + 1 WHERE owner <> $1 AND newest_schema < $2");
        let fence = fence.bind(owner).bind(self.usable_from).execute(&mut *transaction).await;
        fence.map_err(ServerError::mark_unreachable)?;
        Ok(transaction.commit().await.map_err(ServerError::mark_unreachable)?)
    }

    /// Fails if a process serves the ledger that could not use it after the migration.
    async fn ensure_no_older_node(&self, db: &mut PgConnection, found: i64, owner: &str) -> Result<()> {
        if !has_table(db, "lease").await? {
            return Ok(());
        }
        let newest_known = if found < FIRST_WITH_RANGE { "24" } else { "newest_schema" };
        let older = sqlx::query_scalar(AssertSqlSafe(format!(
            "SELECT name || ' (' || owner || ')' FROM lease WHERE until > clock_timestamp() AND owner <> $1 \
             AND left(name, 5) <> 'duty ' AND (name = 'ledger' OR {newest_known} < $2) ORDER BY name"
        )));
        let older: Vec<String> = older.bind(owner).bind(self.usable_from).fetch_all(db).await?;
        match older.is_empty() {
            true => Ok(()),
            false => Err(ServerError::OlderNodes { nodes: older.join(", ") }.into()),
        }
    }

    /// Fails unless this binary can use the ledger: its schema is the binary's own, or has only additions to it.
    pub(super) async fn ensure_usable(&self, pool: &PgPool, label: &str) -> Result<()> {
        let compare = async {
            let mut db = pool.acquire().await.map_err(ServerError::mark_unreachable)?;
            let found = newest_version(&mut db).await?;
            if found > self.newest {
                let range = sqlx::query_scalar("SELECT usable_from FROM schema_range");
                let usable_from: i64 = range.fetch_one(&mut *db).await.map_err(ServerError::mark_unreachable)?;
                if usable_from <= self.newest {
                    return Ok(());
                }
            }
            schema::compare_versions(label.into(), found, self.newest)
        };
        answered_within(ConnectionUser::RightHolder.answered_within(), compare).await
    }

    /// Fails unless the schema is exactly that of this binary.
    pub(super) async fn ensure_own(&self, pool: &PgPool, label: &str) -> Result<()> {
        let mut db = pool.acquire().await.map_err(ServerError::mark_unreachable)?;
        schema::compare_versions(label.into(), newest_version(&mut db).await?, self.newest)
    }
}

#[cfg(test)]
impl ServerSchema {
    /// The schema of a newer nestd, which has more migrations: version, text, and whether it is additive.
    pub(super) fn newer(added: &[(i64, &'static str, bool)]) -> Self {
        let added = added.iter().map(|&(version, text, is_additive)| ServerMigration {
            is_additive,
            ..migration(version, "of a newer nestd", text)
        });
        Self::of(&MIGRATIONS.into_iter().chain(added).collect::<Vec<_>>())
    }
}

/// Tells what passes from what does not.
fn name_cause(error: MigrateError, label: &str) -> LedgerError {
    match error {
        MigrateError::Execute(error) | MigrateError::ExecuteMigration(error, _) => {
            let code = error.as_database_error().and_then(|error| error.code().map(String::from));
            match code.as_deref() {
                // A lock was not free in time; a deadlock.
                Some("55P03" | "40P01") => ServerError::SchemaInUse.into(),
                _ => ServerError::mark_unreachable(error).into(),
            }
        }
        error => LedgerError::Migrate { path: label.into(), error },
    }
}

/// The newest migration of the database; 0 = it holds no ledger.
async fn newest_version(db: &mut PgConnection) -> Result<i64> {
    if !has_table(db, "_sqlx_migrations").await? {
        return Ok(0);
    }
    let newest = sqlx::query_scalar("SELECT coalesce(max(version), 0) FROM _sqlx_migrations");
    Ok(newest.fetch_one(db).await.map_err(ServerError::mark_unreachable)?)
}

/// Whether the database has a table with this name.
pub(super) async fn has_table(db: &mut PgConnection, name: &str) -> Result<bool> {
    let found = sqlx::query_scalar("SELECT to_regclass($1) IS NOT NULL").bind(name).fetch_one(db).await;
    Ok(found.map_err(ServerError::mark_unreachable)?)
}
