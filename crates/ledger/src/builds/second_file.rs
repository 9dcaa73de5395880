//! Second files of a published build, which people copied into a queue folder: where two lay, nobody can say from the folders which of
//! them was printed. What was seen is an event, and holds until nestd has moved the file or a person has looked: a person who moves it says nothing of
//! the other one.

use crate::{
    BuildId, BuildRow, BuildState, EventKind, Ledger,
    base::{error::Result, sql},
    store::change::LedgerChange,
};

const SECOND_FILES: &str = "SELECT detail FROM event WHERE build_id = $1 AND kind = 'second_file' AND id > \
    (SELECT coalesce(max(id), 0) FROM event WHERE build_id = $1 AND kind IN ('relocated', 'seen')) ORDER BY id";

impl Ledger {
    /// Where second files of a build were seen, as `job.3mf at left`.
    pub async fn second_files(&self, build: BuildId) -> Result<Vec<String>> {
        Ok(sql::query_scalar(SECOND_FILES).bind(build).fetch_all(self.reader()?).await?)
    }

    /// Those of the newest published builds of a machine of which second files were seen.
    pub async fn builds_with_second_files(&self, machine: &str, limit: u32) -> Result<Vec<BuildRow>> {
        let query = sql::select_as(
            "FROM build WHERE id IN (SELECT id FROM build WHERE machine = $1 AND state = 'published' ORDER BY id DESC LIMIT $2) \
             AND EXISTS (SELECT 1 FROM event e WHERE e.build_id = build.id AND e.kind = 'second_file' AND e.id > \
             (SELECT coalesce(max(s.id), 0) FROM event s WHERE s.build_id = build.id AND s.kind IN ('relocated', 'seen'))) ORDER BY id",
        );
        Ok(query.bind(machine).bind(limit).fetch_all(self.reader()?).await?)
    }

    /// A second file of a published build was seen at this place.
    pub async fn record_second_file(&self, build: BuildId, place: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        let (machine, state) = change.require_build(build).await?;
        if state == BuildState::Published
            && !second_files_of(&mut change, build).await?.iter().any(|seen| seen == place)
        {
            change.write_event(EventKind::SecondFile, &machine, None, Some(build), place).await?;
            change.commit().await?;
        }
        Ok(())
    }
}

/// Same as [`Ledger::second_files`] within a change.
pub(crate) async fn second_files_of(change: &mut LedgerChange, build: BuildId) -> Result<Vec<String>> {
    Ok(sql::query_scalar(SECOND_FILES).bind(build).fetch_all(change.db()).await?)
}
