//! Breaking a build out: what people say of each copy when it comes out of the cake. Several people may work on one build. The marks
//! are a log: the last one of a copy counts, and taking one back is a mark, too.

use std::{
    collections::{BTreeMap, BTreeSet},
    ops::RangeInclusive,
};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::outcome::{move_to_outcome, record_told};
use crate::{
    BuildId, BuildState, Ledger, LedgerError, PartId, PrintOutcome, PutBackReport, ToldOutcome, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, sql_row},
        text_column::own_word,
    },
    store::change::LedgerChange,
};

/// States of a build whose cake can be broken out.
const PRINTED_STATES: &[BuildState] =
    &[BuildState::Published, BuildState::Printing, BuildState::Complete, BuildState::Interrupted];

/// What somebody says of a copy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum PickMark {
    /// It is out of the cake, and good.
    Out,
    /// It is out of the cake, and bad.
    Bad,
    /// It was not found.
    Missing,
    /// What was said before is taken back: it is still in the cake.
    Open,
}

own_word!(PickMark);

impl PickMark {
    /// Whether a copy with this mark must be printed again.
    pub fn is_lost(self) -> bool {
        matches!(self, Self::Bad | Self::Missing)
    }
}

/// What was said of a copy last.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PickMarkRow {
    /// Its number; a later mark has a greater one.
    pub id: i64,
    /// The part.
    pub part_id: PartId,
    /// Its copy, from 0.
    pub copy: u32,
    /// What was said.
    pub mark: PickMark,
    /// Who said it.
    pub told_by: String,
    /// When.
    pub told_at: UtcTimestamp,
}

sql_row!(PickMarkRow { id, part_id, copy, mark, told_by, told_at });

/// What became of the wish to tell the outcome of a build that was broken out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BreakOutAnswer {
    /// Nothing is told yet: of so many copies nobody said anything.
    Open(u32),
    /// The outcome is told.
    Told(PutBackReport),
}

impl Ledger {
    /// Records what somebody says of a copy in a published build who was shown the mark `seen`; 0 = that nothing was said of it. Where
    /// somebody said something since, it is returned, and nothing is recorded; also where another person said the same.
    pub async fn mark_pick(
        &self,
        build: BuildId,
        copy: (PartId, u32),
        mark: PickMark,
        seen: i64,
        told_by: &str,
    ) -> Result<Option<PickMarkRow>> {
        let mut change = self.begin_change().await?;
        change.ensure_build_state(build, PRINTED_STATES).await?;
        let known = record_mark(&mut change, build, copy, (mark, seen), told_by).await?;
        change.commit().await?;
        Ok(known)
    }

    /// Records the same of several copies in a published build of which nobody said anything, of all or of none. What somebody says
    /// meanwhile of one of them stays, and is returned.
    pub async fn mark_picks(
        &self,
        build: BuildId,
        copies: &[(PartId, u32)],
        mark: PickMark,
        told_by: &str,
    ) -> Result<Vec<PickMarkRow>> {
        let mut change = self.begin_change().await?;
        change.ensure_build_state(build, PRINTED_STATES).await?;
        let mut known = Vec::new();
        for copy in copies {
            known.extend(record_mark(&mut change, build, *copy, (mark, 0), told_by).await?);
        }
        change.commit().await?;
        Ok(known)
    }

    /// Takes back the marks with these numbers, where nobody said anything else since and the copy was not told bad. Returns how many
    /// were taken back. What is said at once has numbers one after the other.
    pub async fn undo_picks(&self, build: BuildId, ids: RangeInclusive<i64>, told_by: &str) -> Result<u32> {
        let mut change = self.begin_change().await?;
        change.ensure_build_state(build, PRINTED_STATES).await?;
        let all = sql::select_as("FROM pick_mark WHERE build_id = $1 ORDER BY id").bind(build);
        let marks = last_marks(all.fetch_all(change.db()).await?);
        let mut undone = 0;
        for row in marks.iter().filter(|row| ids.contains(&row.id)) {
            match record_mark(&mut change, build, (row.part_id, row.copy), (PickMark::Open, row.id), told_by).await {
                Err(LedgerError::NotInBuild { .. }) => {}
                Err(error) => return Err(error),
                Ok(_) => undone += 1,
            }
        }
        change.commit().await?;
        Ok(undone)
    }

    /// What was said last of each copy of a build, without what was taken back, in the order in which it was said.
    pub async fn picks_of_build(&self, build: BuildId) -> Result<Vec<PickMarkRow>> {
        let all = sql::select_as("FROM pick_mark WHERE build_id = $1 ORDER BY id").bind(build);
        Ok(last_marks(all.fetch_all(self.reader()?).await?))
    }

    /// Number of the latest mark of any build; 0 if there is none.
    pub async fn last_pick_id(&self) -> Result<i64> {
        let query = "SELECT coalesce(max(id), 0) FROM pick_mark";
        Ok(sql::query_scalar(query).fetch_one(self.reader()?).await?)
    }
}

/// Tells within a change that a build is printed, once something was said of each of its copies: those that are bad or were not found
/// wait again. What was told of it before stays.
pub(crate) async fn end_break_out(change: &mut LedgerChange, build: BuildId, told_by: &str) -> Result<BreakOutAnswer> {
    let (_, state) = change.require_build(build).await?;
    let counted: Vec<(PartId, u32)> =
        sql::query_as("SELECT part_id, copy FROM placement WHERE build_id = $1 ORDER BY part_id, copy")
            .bind(build)
            .fetch_all(change.db())
            .await?;
    let all = sql::select_as("FROM pick_mark WHERE build_id = $1 ORDER BY id").bind(build);
    let marks = last_marks(all.fetch_all(change.db()).await?);
    let of: BTreeMap<_, _> = marks.iter().map(|row| ((row.part_id, row.copy), row.mark)).collect();
    let open = counted.iter().filter(|copy| !of.contains_key(copy)).count() as u32;
    if open > 0 {
        return Ok(BreakOutAnswer::Open(open));
    }
    let mut lost = counted;
    lost.retain(|copy| of.get(copy).is_some_and(|mark| mark.is_lost()));
    let is_told = matches!(state, BuildState::Complete | BuildState::Interrupted);
    let mut report = PutBackReport::default();
    if is_told && lost.is_empty() {
        return Ok(BreakOutAnswer::Told(report));
    }
    let outcome = if state == BuildState::Interrupted { PrintOutcome::Interrupted } else { PrintOutcome::Complete };
    let told =
        ToldOutcome { is_correction: is_told, ..ToldOutcome::new(outcome, "told when it was broken out", told_by) };
    move_to_outcome(change, build, &told).await?;
    record_told(change, build, &told).await?;
    change.mark_bad(build, &lost, told_by, true, &mut report).await?;
    let parts: BTreeSet<PartId> = of.into_keys().map(|(part, _)| part).collect();
    change.update_orders_of(parts).await?;
    Ok(BreakOutAnswer::Told(report))
}

/// Records a mark within a change, as [`Ledger::mark_pick`] says.
async fn record_mark(
    change: &mut LedgerChange,
    build: BuildId,
    (part, copy): (PartId, u32),
    (mark, seen): (PickMark, i64),
    told_by: &str,
) -> Result<Option<PickMarkRow>> {
    let stands: u32 =
        sql::query_scalar("SELECT count(*) FROM placement WHERE build_id = $1 AND part_id = $2 AND copy = $3")
            .bind(build)
            .bind(part)
            .bind(copy)
            .fetch_one(change.db())
            .await?;
    if stands == 0 {
        return Err(LedgerError::NotInBuild { part, copy, build });
    }
    let last: Option<PickMarkRow> =
        sql::select_as("FROM pick_mark WHERE build_id = $1 AND part_id = $2 AND copy = $3 ORDER BY id DESC LIMIT 1")
            .bind(build)
            .bind(part)
            .bind(copy)
            .fetch_optional(change.db())
            .await?;
    match last.filter(|last| last.mark != PickMark::Open) {
        Some(last) if last.mark == mark => return Ok(Some(last).filter(|last| last.told_by != told_by)),
        Some(last) if last.id != seen => return Ok(Some(last)),
        None if mark == PickMark::Open => return Ok(None),
        _ => {}
    }
    let now = change.now;
    let insert =
        "INSERT INTO pick_mark (build_id, part_id, copy, mark, told_by, told_at) VALUES ($1, $2, $3, $4, $5, $6)";
    let insert = sql::query(insert).bind(build).bind(part).bind(copy).bind(mark).bind(told_by).bind(now);
    insert.execute(change.db()).await?;
    Ok(None)
}

/// The last mark of each copy, without those that were taken back.
fn last_marks(all: Vec<PickMarkRow>) -> Vec<PickMarkRow> {
    let last: BTreeMap<(PartId, u32), PickMarkRow> =
        all.into_iter().map(|row| ((row.part_id, row.copy), row)).collect();
    let mut marks: Vec<PickMarkRow> = last.into_values().filter(|row| row.mark != PickMark::Open).collect();
    marks.sort_by_key(|row| row.id);
    marks
}
