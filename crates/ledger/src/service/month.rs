//! What a report of a span of time needs besides the history: copies that were printed badly, and what came late.

use jiff::{SignedDuration, Timestamp};
use schemars::JsonSchema;
use serde::Serialize;

use super::printer::BEGUN_AT;
use crate::{
    BuildId, Ledger, PartId, PartState, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, sql_row},
    },
};

/// Between the publication of a part and the word that it is good is less time than this.
const LONGEST_PRINT: SignedDuration = SignedDuration::from_hours(90 * 24);

/// Copies of a published build that were printed badly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BadCopies {
    /// The build.
    pub build: BuildId,
    /// How many of its copies.
    pub copies: u32,
}

sql_row!(BadCopies { build, copies });

/// A part that was told good, or is not printed yet, after its due date.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct LatePart {
    /// Number of the part.
    pub part: PartId,
    /// Machine.
    pub machine: String,
    /// File name as dropped.
    pub name: String,
    /// Order, "" = none.
    pub order_name: String,
    /// When it was due.
    pub due_at: UtcTimestamp,
    /// The due date as it was given, "" = not known.
    pub due_text: String,
    /// Its state.
    pub state: PartState,
    /// When the last of its copies was told good, or its print ended, as far as is known; `None` = not all are printed.
    pub done_at: Option<UtcTimestamp>,
    /// Whether nobody told that its print ended: that is an estimate.
    pub is_estimated: bool,
}

sql_row!(LatePart { part, machine, name, order_name, due_at, due_text, state, done_at, is_estimated });

/// A print of copies of a part with a due date, whose end nobody told.
#[derive(Debug, Clone, PartialEq)]
pub struct UntoldPrint {
    /// The part, done when the print began, as far as is known: when its file was taken, or else published.
    pub part: LatePart,
    /// The build.
    pub build: BuildId,
    /// Its height, mm.
    pub height_mm: f64,
}

sql_row!(UntoldPrint { build, height_mm; part });

impl Ledger {
    /// The bad copies of the builds that were published in a span of time.
    pub async fn bad_copies_between(&self, since: Timestamp, until: Timestamp) -> Result<Vec<BadCopies>> {
        let query = sql::query_as(
            "SELECT b.id AS build, (SELECT count(*) FROM bad_placement l WHERE l.build_id = b.id) AS copies FROM build b \
             WHERE b.state NOT IN ('open', 'nesting') AND coalesce(b.published_at, b.state_at) >= $1 \
             AND coalesce(b.published_at, b.state_at) < $2 ORDER BY b.id",
        );
        Ok(query.bind(UtcTimestamp(since)).bind(UtcTimestamp(until)).fetch_all(self.reader()?).await?)
    }

    /// The parts with a due date in a span of time whose copies were told good later, or that are not printed at `now` although it has
    /// passed; by due date.
    pub async fn late_parts(&self, since: Timestamp, until: Timestamp, now: Timestamp) -> Result<Vec<LatePart>> {
        let query = sql::query_as(
            "SELECT part, machine, name, order_name, due_at, due_text, state, done_at, 1 = 0 AS is_estimated FROM (\
             SELECT p.id AS part, p.machine, p.name, p.order_name, p.due_at, p.due_text, p.state, \
             CASE WHEN p.state = 'built' AND NOT EXISTS (SELECT 1 FROM placement l JOIN build b ON b.id = l.build_id \
             WHERE l.part_id = p.id AND b.state <> 'complete') \
             THEN (SELECT max(b.state_at) FROM placement l JOIN build b ON b.id = l.build_id WHERE l.part_id = p.id) END AS done_at \
             FROM part p WHERE p.id IN (\
             SELECT id FROM part WHERE state = 'built' AND state_at >= $4 AND due_at >= $1 AND due_at < $2 \
             UNION ALL SELECT id FROM part WHERE state IN ('claimed', 'waiting', 'batched') AND due_at >= $1 AND due_at < $2)) AS due \
             WHERE (done_at IS NOT NULL AND done_at > due_at) OR (state <> 'built' AND due_at < $3) ORDER BY due_at, part",
        );
        // What was told good after its due date was not published long before.
        let built_since = since.checked_sub(LONGEST_PRINT).unwrap_or(Timestamp::MIN);
        let query = query.bind(UtcTimestamp(since)).bind(UtcTimestamp(until)).bind(UtcTimestamp(now));
        let query = query.bind(UtcTimestamp(built_since));
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// The prints whose end nobody told, of parts with a due date in a span of time of which no copy waits.
    pub async fn untold_prints(&self, since: Timestamp, until: Timestamp) -> Result<Vec<UntoldPrint>> {
        let query = format!(
            "SELECT DISTINCT p.id AS part, p.machine, p.name, p.order_name, p.due_at, p.due_text, p.state, \
             coalesce({BEGUN_AT}, build.published_at) AS done_at, 1 = 1 AS is_estimated, build.id AS build, \
             coalesce(build.height_mm, 0.0) AS height_mm FROM part p \
             JOIN placement l ON l.part_id = p.id JOIN build ON build.id = l.build_id \
             WHERE p.state = 'built' AND p.state_at >= $3 AND p.due_at >= $1 AND p.due_at < $2 \
             AND build.state IN ('published', 'printing') ORDER BY p.due_at, p.id"
        );
        let built_since = since.checked_sub(LONGEST_PRINT).unwrap_or(Timestamp::MIN);
        let query = sql::query_as(sqlx::AssertSqlSafe(query));
        let query = query.bind(UtcTimestamp(since)).bind(UtcTimestamp(until)).bind(UtcTimestamp(built_since));
        Ok(query.fetch_all(self.reader()?).await?)
    }
}
