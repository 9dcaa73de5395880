//! What a plan of a machine reads: what earlier builds teach of the next ones (how high parts stand, and how often a print or a
//! copy is bad), and the parts that cannot be planned yet.

use crate::{
    BuildId, BuildState, Ledger, PartRow, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, sql_row},
    },
    rows::precedence::sort_by_precedence,
};

/// A build that was published, as it is learned from.
#[derive(Debug, Clone, PartialEq)]
pub struct PublishedExperience {
    /// Its number.
    pub build: BuildId,
    /// Its state.
    pub state: BuildState,
    /// Build height, mm.
    pub height_mm: f64,
    /// Volume of the parts in it, mm3.
    pub part_volume_mm3: f64,
    /// Copies in it.
    pub copies: u32,
    /// Copies of it that are told bad.
    pub bad_copies: u32,
    /// When its file was put into the queue.
    pub published_at: UtcTimestamp,
    /// When it entered its state: for one that is complete, when that was told.
    pub state_at: UtcTimestamp,
}

sql_row!(PublishedExperience { build, state, height_mm, part_volume_mm3, copies, bad_copies, published_at, state_at });

impl Ledger {
    /// The last published builds of a machine that were not taken back out of the queue, the newest first.
    pub async fn published_experience(&self, machine: &str, limit: u32) -> Result<Vec<PublishedExperience>> {
        let query = sql::query_as(
            "SELECT id AS build, state, height_mm, part_volume_mm3, coalesce(copies, 0) AS copies, \
             (SELECT count(*) FROM bad_placement l WHERE l.build_id = build.id) AS bad_copies, published_at, state_at FROM build \
             WHERE machine = $1 AND state NOT IN ('open', 'nesting') AND published_at IS NOT NULL AND height_mm IS NOT NULL \
             AND part_volume_mm3 IS NOT NULL AND withdrawn_at IS NULL ORDER BY coalesce(published_at, state_at) DESC, id DESC LIMIT $2",
        );
        Ok(query.bind(machine).bind(limit).fetch_all(self.reader()?).await?)
    }

    /// The parts of a machine that are wanted and cannot be in a build yet: they are not read, wait for an answer or for their
    /// material, or their file is damaged or being fetched; in order of precedence.
    pub async fn unplanned_parts(&self, machine: &str) -> Result<Vec<PartRow>> {
        let query = sql::select_as(
            "FROM part WHERE machine = $1 AND state IN ('claimed', 'waiting') AND replaced_by IS NULL \
             AND (state = 'claimed' OR damaged_at IS NOT NULL OR fetch_at IS NOT NULL OR question <> '' OR awaits_material)",
        );
        let mut parts: Vec<PartRow> = query.bind(machine).fetch_all(self.reader()?).await?;
        sort_by_precedence(&mut parts);
        Ok(parts)
    }
}
