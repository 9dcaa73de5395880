//! Queries of the deep check: where each claimed file must be, and which build a file in the queue belongs to.

use jiff::Timestamp;

use crate::{
    BuildId, Ledger, PartId, PartState, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, sql_row},
    },
    store::consistency::{self, RuleScope},
};

/// The columns of a part that concern its file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PartFileRow {
    /// Its number.
    pub id: PartId,
    /// Name of its claim.
    pub claim: String,
    /// Machine.
    pub machine: String,
    /// File name as dropped, escaped for display.
    pub name: String,
    /// BLAKE3 of the file.
    pub content_hash: String,
    /// Size of the file.
    pub bytes: u64,
    /// Current state.
    pub state: PartState,
    /// When it entered its current state.
    pub state_at: UtcTimestamp,
    /// When its original was requested from the archive; `None` = the store has it.
    pub fetch_at: Option<UtcTimestamp>,
}

sql_row!(PartFileRow { id, claim, machine, name, content_hash, bytes, state, state_at, fetch_at });

/// A part with a copy in a published build.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BuiltPartRow {
    /// The build.
    pub build: BuildId,
    /// Machine.
    pub machine: String,
    /// Name of the build file.
    pub file_name: String,
    /// The part.
    pub part: PartId,
    /// File name as dropped, escaped for display.
    pub name: String,
    /// BLAKE3 of the file.
    pub content_hash: String,
}

sql_row!(BuiltPartRow { build, machine, file_name, part, name, content_hash });

impl Ledger {
    /// Checks every row and describes inconsistencies in sentences. Empty = no inconsistency.
    pub async fn find_inconsistencies(&self) -> Result<Vec<String>> {
        self.find_inconsistencies_in(&RuleScope::ALL).await
    }

    /// The same for some of the rules.
    pub async fn find_inconsistencies_of(&self, scope: RuleScope) -> Result<Vec<String>> {
        self.find_inconsistencies_in(&[scope]).await
    }

    async fn find_inconsistencies_in(&self, scopes: &[RuleScope]) -> Result<Vec<String>> {
        let mut snapshot = self.begin_snapshot().await?;
        snapshot.allow_whole_ledger().await?;
        consistency::find_inconsistencies(&mut snapshot, scopes).await
    }

    /// All parts that are not built, oldest first.
    pub async fn unbuilt_part_files(&self) -> Result<Vec<PartFileRow>> {
        let query = sql::query_as(
            "SELECT id, claim, machine, name, content_hash, bytes, state, state_at, fetch_at FROM part \
             WHERE state <> 'built' ORDER BY id",
        );
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// The parts of all builds published since a time, by build and part.
    pub async fn built_parts_since(&self, since: Timestamp) -> Result<Vec<BuiltPartRow>> {
        let query = sql::query_as(
            "SELECT DISTINCT b.id AS build, b.machine, b.file_name, p.id AS part, p.name, p.content_hash FROM build b \
             JOIN build_copy l ON l.build_id = b.id JOIN part p ON p.id = l.part_id \
             WHERE b.published_at >= $1 AND b.file_name IS NOT NULL ORDER BY b.id, p.id",
        );
        Ok(query.bind(UtcTimestamp(since)).fetch_all(self.reader()?).await?)
    }

    /// Whether a part was ever refused or cancelled.
    pub async fn was_refused(&self, part: PartId) -> Result<bool> {
        let query =
            sql::query_scalar("SELECT EXISTS (SELECT 1 FROM event WHERE part_id = $1 AND kind = 'refused')").bind(part);
        Ok(query.fetch_one(self.reader()?).await?)
    }

    /// Number of files ever recorded, by content hash.
    pub async fn drop_counts_by_hash(&self) -> Result<Vec<(String, u32)>> {
        let query = sql::query_as(
            "SELECT content_hash, count(*) FROM (SELECT claim, content_hash FROM part \
             UNION SELECT claim, content_hash FROM replacement) AS known GROUP BY content_hash ORDER BY content_hash",
        );
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// The newest part of a machine with this content.
    pub async fn find_part_with_content(&self, machine: &str, hash: &str) -> Result<Option<PartFileRow>> {
        let query = sql::query_as(
            "SELECT id, claim, machine, name, content_hash, bytes, state, state_at, fetch_at FROM part \
             WHERE machine = $1 AND content_hash = $2 ORDER BY id DESC LIMIT 1",
        );
        Ok(query.bind(machine).bind(hash).fetch_optional(self.reader()?).await?)
    }
}
