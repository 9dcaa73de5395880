//! Copies that were printed badly: their placements do not count any more, and the copies are owed again, with
//! everything that was asked with them. They go first.

use std::collections::{BTreeMap, BTreeSet};

use build_file::format_count;
use serde::Serialize;

use crate::{
    BuildId, BuildState, EventKind, Ledger, LedgerError, PartId, PartState,
    base::{error::Result, sql},
    builds::nesting::group_by_part,
    store::change::LedgerChange,
};

/// Copies of a part.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PartCopies {
    /// The part.
    pub part: PartId,
    /// File name as dropped.
    pub name: String,
    /// Number of copies.
    pub copies: u32,
}

/// What became of copies that were told bad, or good after all.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct PutBackReport {
    /// Copies that wait again.
    pub put_back: Vec<PartCopies>,
    /// Copies that nobody wants any more: their part was cancelled or refused since, or they are not to be printed again.
    pub unwanted: Vec<PartCopies>,
    /// Copies that count as printed well again.
    pub returned: Vec<PartCopies>,
    /// Copies that are in another build by now: nothing is taken out of it.
    pub elsewhere: Vec<(PartCopies, BuildId)>,
}

impl PutBackReport {
    /// Number of copies that wait again.
    pub fn put_back_copies(&self) -> u32 {
        count_all(&self.put_back)
    }

    /// What became of the copies, in sentences for people.
    pub fn sentences(&self) -> Vec<String> {
        let mut told = Vec::new();
        let of = |parts: &[PartCopies]| {
            let copies = format_count(count_all(parts), "copy", "copies");
            format!("{copies} of {}", format_count(parts.len(), "part", "parts"))
        };
        if !self.put_back.is_empty() {
            let wait = if count_all(&self.put_back) == 1 { "waits" } else { "wait" };
            told.push(format!("{} {wait} again, first in line, with all that was asked.", of(&self.put_back)));
        }
        if !self.unwanted.is_empty() {
            told.push(format!("Not printed again: {}.", of(&self.unwanted)));
        }
        if !self.returned.is_empty() {
            told.push(format!("Counted as printed again, and waiting no more: {}.", of(&self.returned)));
        }
        for (part, build) in &self.elsewhere {
            let (copies, are, stay, more) = match part.copies {
                1 => ("A copy".to_owned(), "is", "stays", "one more of it is printed"),
                several => (format!("{several} copies"), "are", "stay", "as many more of it are printed"),
            };
            let (part, name) = (part.part, &part.name);
            told.push(format!(
                "{copies} of part {part} ({name}) {are} in build {build} by now, and {stay} there: {more}."
            ));
        }
        told
    }

    /// One more copy of a part is in another build.
    fn add_elsewhere(&mut self, part: PartId, name: String, build: BuildId) {
        match self.elsewhere.iter_mut().find(|(known, other)| known.part == part && *other == build) {
            Some((known, _)) => known.copies += 1,
            None => self.elsewhere.push((PartCopies { part, name, copies: 1 }, build)),
        }
    }
}

fn count_all(parts: &[PartCopies]) -> u32 {
    parts.iter().map(|part| part.copies).sum()
}

/// What is to be printed again.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ReprintTarget {
    /// Every copy of a build.
    Build(BuildId),
    /// The last printed copies of a part; `None` = all of them.
    Part(PartId, Option<u32>),
    /// Every printed copy of an order.
    Order(String),
}

impl Ledger {
    /// The parts whose originals were requested from the archive, oldest first.
    pub async fn parts_to_fetch(&self) -> Result<Vec<crate::PartRow>> {
        let query = sql::select_as("FROM part WHERE fetch_at IS NOT NULL ORDER BY id");
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// The store holds this content, or it is not needed, or was not found: its parts on this node's machines continue.
    pub async fn mark_fetched(&self, hash: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        let mark = sql::query(
            "UPDATE part SET fetch_at = NULL WHERE content_hash = $1 AND fetch_at IS NOT NULL \
             AND ($2 = '' OR machine NOT IN (SELECT machine FROM station WHERE node NOT IN ('', $2)))",
        );
        mark.bind(hash).bind(self.node()).execute(change.db()).await?;
        change.commit().await
    }

    /// Names of the build files that hold copies of parts with this content, newest first.
    pub async fn build_files_with_content(&self, hash: &str) -> Result<Vec<(String, String)>> {
        let query = sql::query_as(
            "SELECT b.machine, b.file_name FROM build b WHERE b.file_name IS NOT NULL AND b.id IN (\
             SELECT l.build_id FROM part p JOIN placement l ON l.part_id = p.id WHERE p.content_hash = $1 \
             UNION SELECT l.build_id FROM part p JOIN bad_placement l ON l.part_id = p.id WHERE p.content_hash = $1) \
             ORDER BY b.id DESC",
        );
        Ok(query.bind(hash).fetch_all(self.reader()?).await?)
    }
}

/// The copies that a reprint means: those in published builds, of a part the last printed ones.
pub(crate) async fn printed_copies(
    change: &mut LedgerChange,
    target: &ReprintTarget,
) -> Result<Vec<(BuildId, PartId, u32)>> {
    let mut copies: Vec<(BuildId, PartId, u32)> = match target {
        ReprintTarget::Build(build) => {
            let printed = &[BuildState::Published, BuildState::Printing, BuildState::Complete, BuildState::Interrupted];
            if change.require_build(*build).await?.1 != BuildState::Failed {
                change.ensure_build_state(*build, printed).await?;
            }
            sql::query_as("SELECT build_id, part_id, copy FROM placement WHERE build_id = $1").bind(build)
        }
        .fetch_all(change.db())
        .await?,
        ReprintTarget::Part(part, _) => {
            change.require_part(*part).await?;
            sql::query_as(
                "SELECT l.build_id, l.part_id, l.copy FROM placement l JOIN build b ON b.id = l.build_id \
                 WHERE l.part_id = $1 AND b.published_at IS NOT NULL ORDER BY b.published_at DESC, l.copy DESC",
            )
            .bind(part)
            .fetch_all(change.db())
            .await?
        }
        ReprintTarget::Order(name) => sql::query_as(
            "SELECT l.build_id, l.part_id, l.copy FROM part p JOIN placement l ON l.part_id = p.id \
             JOIN build b ON b.id = l.build_id WHERE p.order_name = $1 AND p.order_name <> '' AND b.published_at IS NOT NULL",
        )
        .bind(name)
        .fetch_all(change.db())
        .await?,
    };
    if let ReprintTarget::Part(part, Some(most)) = target {
        if (copies.len() as u32) < *most {
            return Err(LedgerError::TooFewPrinted { part: *part, asked: *most, printed: copies.len() as u32 });
        }
        copies.truncate(*most as usize);
    }
    match copies.is_empty() {
        true => Err(LedgerError::NothingPrinted),
        false => Ok(copies),
    }
}

impl LedgerChange {
    /// Who tells that copies are bad that a later build was made of, as its record in the archive says after a restore.
    pub const TOLD_BY_RECORD: &str = "the record of a later build";

    /// Records that copies in a published build are bad. `is_owed` = they are to be printed again.
    pub async fn mark_bad(
        &mut self,
        build: BuildId,
        copies: &[(PartId, u32)],
        told_by: &str,
        is_owed: bool,
        report: &mut PutBackReport,
    ) -> Result<()> {
        let parts: BTreeSet<PartId> = copies.iter().map(|&(part, _)| part).collect();
        self.forget_dropped_word(build).await?;
        for (id, copies) in group_by_part(copies) {
            let part = self.require_part(id).await?;
            let is_owed = is_owed && part.state != PartState::Refused;
            for &copy in &copies {
                self.move_to_bad(build, id, copy, told_by, is_owed).await?;
            }
            let number = copies.len() as u32;
            let counted = PartCopies { part: id, name: part.full_name(), copies: number };
            let text = format_count(number, "copy", "copies");
            match (is_owed, part.state) {
                (true, state) => {
                    let detail = format!("{text} put back from build {build} by {told_by}");
                    self.put_part_back(id, state, build, &detail).await?;
                    self.reopen_finishing(id).await?;
                    report.put_back.push(counted);
                }
                (false, PartState::Refused) => report.unwanted.push(counted),
                (false, _) => {
                    self.change_cancelled(id, i64::from(number)).await?;
                    let detail = format!("{text} of build {build} not wanted again, as {told_by} said");
                    self.write_event(EventKind::CopiesCancelled, &part.machine, Some(id), Some(build), &detail).await?;
                    self.note_wanted_change(-i64::from(number)).await?;
                    report.unwanted.push(counted);
                }
            }
        }
        self.update_orders_of(parts).await
    }

    /// Somebody has said how a build was printed: a word about it that was dropped is told no more.
    pub(super) async fn forget_dropped_word(&mut self, build: BuildId) -> Result<()> {
        let set = sql::query("UPDATE build SET word_dropped = NULL WHERE id = $1 AND word_dropped IS NOT NULL");
        set.bind(build).execute(self.db()).await?;
        Ok(())
    }

    async fn move_to_bad(
        &mut self,
        build: BuildId,
        part: PartId,
        copy: u32,
        told_by: &str,
        is_owed: bool,
    ) -> Result<()> {
        let now = self.now;
        sql::query(
            "INSERT INTO bad_placement (build_id, part_id, copy, qx, qy, qz, qw, tx_mm, ty_mm, tz_mm, drawn, way_x, \
             way_y, way_z, told_by, told_at, is_owed) \
             SELECT build_id, part_id, copy, qx, qy, qz, qw, tx_mm, ty_mm, tz_mm, drawn, way_x, way_y, way_z, $1, $2, $3 \
             FROM placement WHERE part_id = $4 AND copy = $5 AND build_id = $6",
        )
        .bind(told_by)
        .bind(now)
        .bind(is_owed)
        .bind(part)
        .bind(copy)
        .bind(build)
        .execute(self.db())
        .await?;
        let lift = sql::query("DELETE FROM placement WHERE part_id = $1 AND copy = $2 AND build_id = $3");
        if lift.bind(part).bind(copy).bind(build).execute(self.db()).await? == 0 {
            return Err(LedgerError::NotInBuild { part, copy, build });
        }
        Ok(())
    }

    /// A part waits again and goes first. The original of a built part lies in the archive.
    async fn put_part_back(&mut self, id: PartId, state: PartState, build: BuildId, detail: &str) -> Result<()> {
        let now = self.now;
        let fetch = (state == PartState::Built).then_some(now);
        // Where none waits yet, they wait from now on. What is taken back out of the queue was not printed, and has waited since before.
        let since = matches!(state, PartState::Built | PartState::Batched).then_some(now);
        sql::query(
            "UPDATE part SET put_back_at = coalesce(put_back_at, $1), fetch_at = coalesce(fetch_at, $2), waits_since = \
             CASE WHEN EXISTS (SELECT 1 FROM build WHERE id = $5 AND withdraw_by IS NOT NULL) THEN waits_since \
             ELSE coalesce($3, waits_since) END WHERE id = $4",
        )
        .bind(now)
        .bind(fetch)
        .bind(since)
        .bind(id)
        .bind(build)
        .execute(self.db())
        .await?;
        let machine = self.require_part(id).await?.machine;
        self.write_event(EventKind::PutBack, &machine, Some(id), Some(build), detail).await?;
        self.count_decision(id).await?;
        match state {
            PartState::Built | PartState::Batched => self.move_part(id, PartState::Waiting, Some(build), detail).await,
            _ => Ok(()),
        }
    }

    /// Copies of a build that were told bad count as good again, unless they are in another build by now.
    pub async fn return_bad_copies(&mut self, build: BuildId, report: &mut PutBackReport) -> Result<()> {
        let bad: Vec<(PartId, u32, bool)> = sql::query_as(
            "SELECT part_id, copy, is_owed FROM bad_placement WHERE build_id = $1 ORDER BY part_id, copy",
        )
        .bind(build)
        .fetch_all(self.db())
        .await?;
        let mut returned: BTreeMap<PartId, u32> = BTreeMap::new();
        for (id, copy, is_owed) in bad {
            let part = self.require_part(id).await?;
            let holder: Option<BuildId> =
                sql::query_scalar("SELECT build_id FROM placement WHERE part_id = $1 AND copy = $2")
                    .bind(id)
                    .bind(copy)
                    .fetch_optional(self.db())
                    .await?;
            if let Some(holder) = holder {
                report.add_elsewhere(id, part.full_name(), holder);
                continue;
            }
            // Also the copies of a part that is read again wait.
            let may_wait = matches!(part.state, PartState::Waiting | PartState::Claimed);
            let has_waiting = may_wait && self.waiting_count(id).await? > 0;
            let is_wanted_again = match part.state {
                // It takes the place of a refused copy, unless those were given up when their order was closed.
                PartState::Refused => self.placed_count(id).await? >= part.wanted_copies(),
                // Where none is given up any more, it takes that of a copy that was asked for again and waits.
                _ => part.owed.cancelled_copies > 0 && !(is_owed && has_waiting),
            };
            if is_wanted_again {
                self.change_cancelled(id, -1).await?;
                let detail = format!("a copy in build {build} was printed well after all");
                self.write_event(EventKind::CopiesWanted, &part.machine, Some(id), Some(build), &detail).await?;
                self.note_wanted_change(1).await?;
            }
            self.move_from_bad(build, id, copy).await?;
            *returned.entry(id).or_default() += 1;
        }
        for (&id, &copies) in &returned {
            report.returned.push(PartCopies { part: id, name: self.require_part(id).await?.full_name(), copies });
            self.end_waiting(id, Some(build)).await?;
        }
        self.update_orders_of(returned.into_keys()).await
    }

    async fn move_from_bad(&mut self, build: BuildId, part: PartId, copy: u32) -> Result<()> {
        sql::query(
            "INSERT INTO placement (build_id, part_id, copy, qx, qy, qz, qw, tx_mm, ty_mm, tz_mm, drawn, way_x, way_y, way_z) \
             SELECT build_id, part_id, copy, qx, qy, qz, qw, tx_mm, ty_mm, tz_mm, drawn, way_x, way_y, way_z \
             FROM bad_placement WHERE build_id = $1 AND part_id = $2 AND copy = $3",
        )
        .bind(build)
        .bind(part)
        .bind(copy)
        .execute(self.db())
        .await?;
        let lift = sql::query("DELETE FROM bad_placement WHERE build_id = $1 AND part_id = $2 AND copy = $3");
        lift.bind(build).bind(part).bind(copy).execute(self.db()).await?;
        Ok(())
    }

    /// Number of copies of a part that wait for a build.
    pub async fn waiting_count(&mut self, id: PartId) -> Result<u32> {
        let wanted = self.require_part(id).await?.wanted_copies();
        let placed = self.placed_count(id).await?;
        Ok(wanted.saturating_sub(placed))
    }

    /// Changes the number of copies that are not wanted any more.
    pub async fn change_cancelled(&mut self, id: PartId, by: i64) -> Result<()> {
        let set = sql::query(
            "UPDATE part SET cancelled_copies = \
             CASE WHEN cancelled_copies + $1 > 0 THEN cancelled_copies + $1 ELSE 0 END WHERE id = $2",
        );
        set.bind(by).bind(id).execute(self.db()).await?;
        Ok(())
    }

    /// waiting -> batched, built, if no copy of the part waits any more.
    pub async fn end_waiting(&mut self, id: PartId, build: Option<BuildId>) -> Result<()> {
        if self.require_part(id).await?.state != PartState::Waiting || self.waiting_count(id).await? > 0 {
            return Ok(());
        }
        self.move_part(id, PartState::Batched, build, "no copy waits any more").await?;
        let open: u32 = sql::query_scalar(
            "SELECT count(*) FROM placement l JOIN build b ON b.id = l.build_id \
             WHERE l.part_id = $1 AND b.published_at IS NULL",
        )
        .bind(id)
        .fetch_one(self.db())
        .await?;
        if open == 0 {
            self.move_part(id, PartState::Built, build, "no copy waits any more").await?;
            sql::query("UPDATE part SET fetch_at = NULL, put_back_at = NULL WHERE id = $1")
                .bind(id)
                .execute(self.db())
                .await?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_in_another_build_are_told_once_with_their_number() {
        let mut report = PutBackReport::default();
        for (part, build) in [(1, 5), (1, 5), (2, 5), (1, 6)] {
            report.add_elsewhere(PartId(part), format!("{part}.stl"), BuildId(build));
        }
        let told = report.sentences();
        assert!(told.len() == 3 && told[0].starts_with("2 copies of part 1 (1.stl) are in build 5"), "{told:?}");
        assert!(told[1].ends_with("stays there: one more of it is printed."), "{told:?}");
    }
}
