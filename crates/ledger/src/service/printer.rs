//! Printers that a person has taken out of use, and the builds that lie at a printer.

use jiff::{SignedDuration, Timestamp};
use schemars::JsonSchema;
use serde::Serialize;

use crate::{
    BuildId, BuildRow, BuildState, EventKind, Ledger, LedgerError, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, sql_row},
    },
};

/// A printer that takes no builds.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct DownPrinter {
    /// Its name.
    pub printer: String,
    /// Its machine.
    pub machine: String,
    /// Why, as a person said; "" = not said.
    pub reason: String,
    /// user@host.
    pub told_by: String,
    /// Since when.
    pub down_at: UtcTimestamp,
}

sql_row!(DownPrinter { printer, machine, reason, told_by, down_at });

/// A build that occupies a printer, or will.
#[derive(Debug, Clone, PartialEq)]
pub struct OccupyingBuild {
    /// Its number.
    pub build: BuildId,
    /// The printer; `None` = the only one of its machine, or not decided.
    pub printer: Option<String>,
    /// Its state: nesting, verified, published or printing.
    pub state: BuildState,
    /// Build height, mm.
    pub height_mm: Option<f64>,
    /// When its file was put into the queue.
    pub published_at: Option<UtcTimestamp>,
    /// When its print began, as far as is known: it was told, or the file was taken.
    pub begun_at: Option<UtcTimestamp>,
}

sql_row!(OccupyingBuild { build, printer, state, height_mm, published_at, begun_at });

/// The builds ahead of a printer: made for it, or in its queue.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BuildsAhead {
    /// The printer; "" = it is not decided for which one they are made.
    pub printer: String,
    /// Their number.
    pub builds: u32,
    /// Whether a person took the printer out of use.
    pub is_down: bool,
}

sql_row!(BuildsAhead { printer, builds, is_down });

/// The builds ahead of each printer, and the printers that are down, by machine.
pub(super) const BUILDS_AHEAD: &str = "SELECT machine, printer, CAST(sum(builds) AS BIGINT) AS builds, \
    max(down) > 0 AS is_down FROM (\
    SELECT machine, coalesce(move_to, printer) AS printer, 1 AS builds, 0 AS down FROM build \
    WHERE state = 'published' AND taken_at IS NULL AND printer IS NOT NULL \
    UNION ALL SELECT machine, coalesce(printer, ''), 1, 0 FROM build WHERE state IN ('nesting', 'verified') \
    UNION ALL SELECT machine, printer, 0, 1 FROM printer_down) AS one GROUP BY machine, printer ORDER BY machine, printer";

/// A published build whose outcome nobody told occupies its printer for this time at most.
const FORGOTTEN_AFTER: SignedDuration = SignedDuration::from_hours(30 * 24);
/// Newest prints of a machine from which is learned how long a print takes.
const LEARNED_PRINTS: u32 = 40;

/// A published build that its printer has not taken, as far as is known.
#[derive(Debug, Clone, PartialEq)]
pub struct QueuedBuild {
    /// Its number.
    pub build: BuildId,
    /// Its printer.
    pub printer: String,
    /// Marker of the queue folder where it was published.
    pub queue_id: Option<String>,
    /// Name of its file there.
    pub file_name: Option<String>,
    /// Size of its file.
    pub file_bytes: Option<u64>,
}

sql_row!(QueuedBuild { build, printer, queue_id, file_name, file_bytes });

/// A print whose end a person has told.
#[derive(Debug, Clone, PartialEq)]
pub struct ToldPrint {
    /// The printer; `None` = the only one of its machine.
    pub printer: Option<String>,
    /// Build height, mm.
    pub height_mm: f64,
    /// When it began: that was told, or its file was taken.
    pub begun_at: UtcTimestamp,
    /// When a person told that it was complete.
    pub told_at: UtcTimestamp,
}

sql_row!(ToldPrint { printer, height_mm, begun_at, told_at });

/// A build, the name of its printer, and that of its file.
type PlacedFile = (BuildId, Option<String>, Option<String>);

/// When the print of a build began.
pub(super) const BEGUN_AT: &str =
    "coalesce((SELECT min(o.told_at) FROM outcome o WHERE o.build_id = build.id AND o.outcome = 'printing'), taken_at)";

impl Ledger {
    /// The printers that are down, by machine and name.
    pub async fn down_printers(&self) -> Result<Vec<DownPrinter>> {
        Ok(sql::select_as("FROM printer_down ORDER BY machine, printer").fetch_all(self.reader()?).await?)
    }

    /// Takes a printer out of use; says its reason anew if it is down already.
    pub(crate) async fn take_printer_down(&self, printer: &str, machine: &str, by: &str, reason: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        let now = change.now;
        let insert = "INSERT INTO printer_down (printer, machine, reason, told_by, down_at) VALUES ($1, $2, $3, $4, $5) \
            ON CONFLICT (machine, printer) DO UPDATE SET reason = excluded.reason, told_by = excluded.told_by";
        let insert = sql::query(insert).bind(printer).bind(machine).bind(reason).bind(by).bind(now);
        insert.execute(change.db()).await?;
        let why = if reason.is_empty() { String::new() } else { format!(": {reason}") };
        change.write_event(EventKind::PrinterDown, machine, None, None, &format!("{printer} by {by}{why}")).await?;
        change.commit().await
    }

    /// Puts a printer into use again. Returns `false` if it was not down.
    pub(crate) async fn bring_printer_up(&self, printer: &str, machine: &str, by: &str) -> Result<bool> {
        let mut change = self.begin_change().await?;
        let lift =
            sql::query("DELETE FROM printer_down WHERE machine = $1 AND printer = $2").bind(machine).bind(printer);
        if lift.execute(change.db()).await? == 0 {
            return Ok(false);
        }
        change.write_event(EventKind::PrinterUp, machine, None, None, &format!("{printer} by {by}")).await?;
        change.commit().await?;
        Ok(true)
    }

    /// Writes down for which printer a build is made.
    pub async fn assign_printer(&self, build: BuildId, printer: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.ensure_build_state(build, &[BuildState::Nesting]).await?;
        let set = sql::query("UPDATE build SET printer = $1 WHERE id = $2 AND printer IS DISTINCT FROM $1");
        set.bind(printer).bind(build).execute(change.db()).await?;
        change.commit().await
    }

    /// The newest published builds of a machine whose files were in a queue folder when they were last looked for.
    pub async fn newest_queued(&self, machine: &str, limit: u32) -> Result<Vec<QueuedBuild>> {
        let query = sql::query_as(
            "SELECT id AS build, printer, queue_id, file_name, file_bytes FROM build WHERE machine = $1 AND state = 'published' AND taken_at IS NULL \
             AND printer IS NOT NULL AND move_to IS NULL AND withdraw_by IS NULL ORDER BY id DESC LIMIT $2",
        );
        Ok(query.bind(machine).bind(limit).fetch_all(self.reader()?).await?)
    }

    /// The build of any machine that has this file name.
    pub async fn find_build_of_file(&self, file_name: &str) -> Result<Option<BuildRow>> {
        let query = sql::select_as("FROM build WHERE file_name = $1").bind(file_name);
        Ok(query.fetch_optional(self.reader()?).await?)
    }

    /// Whether copies of a build were told bad.
    pub async fn has_bad_copies(&self, build: BuildId) -> Result<bool> {
        let query = sql::query_scalar("SELECT EXISTS (SELECT 1 FROM bad_placement WHERE build_id = $1)").bind(build);
        Ok(query.fetch_one(self.reader()?).await?)
    }

    /// The builds ahead of each printer of a machine, and its printers that are down.
    pub async fn builds_ahead(&self, machine: &str) -> Result<Vec<BuildsAhead>> {
        let query = format!("SELECT printer, builds, is_down FROM ({BUILDS_AHEAD}) AS ahead WHERE machine = $1");
        Ok(sql::query_as(sqlx::AssertSqlSafe(query)).bind(machine).fetch_all(self.reader()?).await?)
    }

    /// The number of published builds of a machine that were not seen to be taken, by printer.
    pub async fn queued_counts(&self, machine: &str) -> Result<Vec<(String, i64)>> {
        let query = sql::query_as(
            "SELECT printer, count(*) FROM build WHERE machine = $1 AND state = 'published' AND taken_at IS NULL \
             AND printer IS NOT NULL AND move_to IS NULL GROUP BY printer",
        );
        Ok(query.bind(machine).fetch_all(self.reader()?).await?)
    }

    /// Gives the builds in the queue folder with this marker the name of its printer, which may be a new one. Builds of an
    /// earlier nestd, which named no printers, get it if their files are there: `present`.
    pub async fn name_printer(&self, machine: &str, printer: &str, queue_id: &str, present: &[String]) -> Result<()> {
        let others = sql::query_as(
            "SELECT id, printer, file_name FROM build WHERE machine = $1 AND queue_id = $2 AND printer IS DISTINCT FROM $3 \
             AND state IN ('verified', 'published', 'printing')",
        );
        let others = others.bind(machine).bind(queue_id).bind(printer).fetch_all(self.reader()?).await?;
        let is_present = |file: &Option<String>| file.as_ref().is_some_and(|file| present.contains(file));
        let others = others.into_iter().filter(|(_, named, file): &PlacedFile| named.is_some() || is_present(file));
        let others: Vec<BuildId> = others.map(|(build, _, _)| build).collect();
        if others.is_empty() {
            return Ok(());
        }
        let mut change = self.begin_change().await?;
        for build in others {
            let set = sql::query(
                "UPDATE build SET printer = $1 WHERE id = $2 AND queue_id = $3 AND state IN ('verified', 'published', 'printing')",
            );
            set.bind(printer).bind(build).bind(queue_id).execute(change.db()).await?;
        }
        change.commit().await
    }

    /// Records that the file of a published build is gone from the queue folder with this marker: the printer, or a person, took
    /// it. Nothing is recorded if it was moved to another folder since.
    pub async fn record_taken(&self, build: BuildId, queue_id: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        let now = change.now;
        let set = "UPDATE build SET taken_at = coalesce(taken_at, $1) WHERE id = $2 AND move_to IS NULL AND withdraw_by IS NULL \
            AND withdrawn_at IS NULL AND queue_id = $3";
        sql::query(set).bind(now).bind(build).bind(queue_id).execute(change.db()).await?;
        change.commit().await
    }

    /// The builds of a machine that occupy its printers: those that are made, and those published in the last 30 days whose
    /// end was not told, in the order of their publication.
    pub async fn occupying_builds(&self, machine: &str, now: UtcTimestamp) -> Result<Vec<OccupyingBuild>> {
        let since = UtcTimestamp(now.0.checked_sub(FORGOTTEN_AFTER).unwrap_or(Timestamp::MIN));
        let columns =
            format!("SELECT id AS build, printer, state, height_mm, published_at, {BEGUN_AT} AS begun_at FROM build");
        let published = format!(
            "{columns} WHERE machine = $1 AND state NOT IN ('open', 'nesting') AND state IN ('published', 'printing') \
             AND coalesce(published_at, state_at) >= $2 ORDER BY coalesce(published_at, state_at), id"
        );
        let made = format!("{columns} WHERE machine = $1 AND state IN ('nesting', 'verified') ORDER BY id");
        let published = sql::query_as(sqlx::AssertSqlSafe(published)).bind(machine).bind(since);
        let mut builds: Vec<OccupyingBuild> = published.fetch_all(self.reader()?).await?;
        let made = sql::query_as(sqlx::AssertSqlSafe(made)).bind(machine);
        builds.extend(made.fetch_all(self.reader()?).await?);
        Ok(builds)
    }

    /// The last prints of a machine that ended well, of which the begin is known, at most 40, the newest first.
    pub async fn told_prints(&self, machine: &str) -> Result<Vec<ToldPrint>> {
        let query = format!(
            "SELECT printer, height_mm, begun_at, told_at FROM (SELECT printer, height_mm, {BEGUN_AT} AS begun_at, \
             state_at AS told_at FROM build WHERE machine = $1 AND state NOT IN ('open', 'nesting') AND state = 'complete' \
             AND height_mm IS NOT NULL ORDER BY coalesce(published_at, state_at) DESC, id DESC LIMIT $2) AS newest \
             WHERE begun_at IS NOT NULL AND begun_at < told_at"
        );
        let query = sql::query_as(sqlx::AssertSqlSafe(query)).bind(machine).bind(LEARNED_PRINTS);
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// A person said that a proved build may be published. `seen` is the hash of the build file that the person was shown.
    /// Returns `false` if that was said before.
    ///
    /// `WrongState` unless it is proved and not published; `ProvedAnew` if it is another file by now.
    pub(crate) async fn release_build(&self, build: BuildId, seen: Option<&str>, by: &str) -> Result<bool> {
        let mut change = self.begin_change().await?;
        change.ensure_build_state(build, &[BuildState::Verified]).await?;
        let proved = sql::query_as("SELECT machine, file_hash FROM build WHERE id = $1").bind(build);
        let (machine, proved): (String, Option<String>) = proved.fetch_one(change.db()).await?;
        if seen.is_some() && seen != proved.as_deref() {
            return Err(LedgerError::ProvedAnew(build));
        }
        let now = change.now;
        let set = "UPDATE build SET released_at = $1, released_by = $2 WHERE id = $3 AND released_at IS NULL";
        if sql::query(set).bind(now).bind(by).bind(build).execute(change.db()).await? == 0 {
            return Ok(false);
        }
        change.write_event(EventKind::Released, &machine, None, Some(build), &format!("by {by}")).await?;
        change.commit().await?;
        Ok(true)
    }
}
