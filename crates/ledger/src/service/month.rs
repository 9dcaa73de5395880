//! What a report of a span of time needs besides the history: copies that were printed badly, and what came late.

use jiff::Timestamp;
use schemars::JsonSchema;
use serde::Serialize;

use crate::{
    BuildId, Ledger, PartId, PartState, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, sql_row},
    },
};

/// Copies of a published build that were printed badly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BadCopies {
    /// The build.
    pub build: BuildId,
    /// How many of its copies.
    pub copies: u32,
}

sql_row!(BadCopies { build, copies });

/// A part that was, or is, not in a queue by its due date.
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
    /// When its last copy was put into a queue; `None` = copies are still not there.
    pub built_at: Option<UtcTimestamp>,
}

sql_row!(LatePart { part, machine, name, order_name, due_at, due_text, state, built_at });

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

    /// The parts with a due date in a span of time that were built later, or are not built at `now` although it has passed; by
    /// due date.
    pub async fn late_parts(&self, since: Timestamp, until: Timestamp, now: Timestamp) -> Result<Vec<LatePart>> {
        // What is late was built after its due date, so after the begin of the span.
        let query = sql::query_as(
            "SELECT id AS part, machine, name, order_name, due_at, due_text, state, \
             CASE state WHEN 'built' THEN state_at END AS built_at FROM part WHERE id IN (\
             SELECT id FROM part WHERE state = 'built' AND state_at >= $1 AND due_at >= $1 AND due_at < $2 AND due_at < state_at \
             UNION ALL SELECT id FROM part WHERE state IN ('claimed', 'waiting', 'batched') AND due_at >= $1 AND due_at < $2 \
             AND due_at < $3) ORDER BY due_at, id",
        );
        let query = query.bind(UtcTimestamp(since)).bind(UtcTimestamp(until)).bind(UtcTimestamp(now));
        Ok(query.fetch_all(self.reader()?).await?)
    }
}
