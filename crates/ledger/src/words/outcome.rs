//! Outcomes: what users report about published builds.

use std::collections::BTreeSet;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    BuildId, BuildRow, BuildState, EventKind, Ledger, LedgerError, PartCopies, PartId, PutBackReport, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, sql_row},
        text_column::own_word,
    },
    builds::second_file::second_files_of,
    store::change::LedgerChange,
};

/// States of a build in which an outcome can be reported.
const REPORTABLE_STATES: &[BuildState] = &[BuildState::Published, BuildState::Printing];

/// The outcome of a published build.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum PrintOutcome {
    /// The machine has started to print.
    Printing,
    /// Printed.
    Complete,
    /// The machine stopped before the end.
    Interrupted,
    /// The print failed.
    Failed,
}

own_word!(PrintOutcome);

/// A reported outcome.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct OutcomeRow {
    /// Its number.
    pub id: i64,
    /// The build.
    pub build_id: BuildId,
    /// The outcome.
    pub outcome: PrintOutcome,
    /// Free text.
    pub note: String,
    /// user@host.
    pub told_by: String,
    /// When it was reported.
    pub told_at: UtcTimestamp,
    /// Whether it corrects what was told before.
    pub is_correction: bool,
}

sql_row!(OutcomeRow { id, build_id, outcome, note, told_by, told_at, is_correction });

impl PrintOutcome {
    /// The state that a build enters with this outcome.
    fn build_state(self) -> BuildState {
        match self {
            Self::Printing => BuildState::Printing,
            Self::Complete => BuildState::Complete,
            Self::Interrupted => BuildState::Interrupted,
            Self::Failed => BuildState::Failed,
        }
    }
}

/// What somebody tells of a print.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ToldOutcome {
    /// The outcome.
    pub outcome: PrintOutcome,
    /// Free text.
    pub note: String,
    /// user@host.
    pub told_by: String,
    /// Copies that are bad although the print is complete or was interrupted: part and number.
    pub bad: Vec<(PartId, u32)>,
    /// Whether bad copies are not to be printed again.
    pub keep: bool,
    /// Whether it corrects what was told before.
    pub is_correction: bool,
}

impl ToldOutcome {
    /// An outcome without bad copies.
    pub fn new(outcome: PrintOutcome, note: &str, told_by: &str) -> Self {
        let (note, told_by) = (note.to_owned(), told_by.to_owned());
        Self { outcome, note, told_by, bad: Vec::new(), keep: false, is_correction: false }
    }
}

impl PutBackReport {
    /// A copy that counted as good for a moment was told bad again. `stays` = with it nothing else was asked than before.
    fn forget_return(&mut self, part: PartId, stays: bool) {
        let take = |list: &mut Vec<PartCopies>| {
            if let Some(of_part) = list.iter_mut().find(|one| one.part == part) {
                of_part.copies -= 1;
            }
            list.retain(|one| one.copies > 0);
        };
        take(&mut self.returned);
        if stays {
            let is_again = self.put_back.iter().any(|one| one.part == part);
            take(if is_again { &mut self.put_back } else { &mut self.unwanted });
        }
    }
}

impl Ledger {
    /// The outcomes of a build that somebody reported, oldest first: not what a withdrawal recorded, whose event has the same words.
    pub async fn outcomes_of_build(&self, build: BuildId) -> Result<Vec<OutcomeRow>> {
        let query = sql::select_as(
            "FROM outcome WHERE build_id = $1 AND NOT EXISTS (SELECT 1 FROM event e WHERE e.build_id = outcome.build_id \
             AND e.kind = 'withdrawn' AND e.at = outcome.told_at AND e.detail = outcome.note) ORDER BY id",
        )
        .bind(build);
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// Records that somebody has seen to a failed print, or to a second file of a published build: then `true`.
    pub(crate) async fn mark_seen(&self, build: BuildId, by: &str) -> Result<bool> {
        let mut change = self.begin_change().await?;
        let (mut machine, state) = change.require_build(build).await?;
        let has_second = state == BuildState::Published && !second_files_of(&mut change, build).await?.is_empty();
        if !has_second {
            machine = change.ensure_build_state(build, &[BuildState::Failed]).await?;
            let set = sql::query("UPDATE build SET seen_at = coalesce(seen_at, $1) WHERE id = $2");
            set.bind(change.now).bind(build).execute(change.db()).await?;
        }
        change.write_event(EventKind::Seen, &machine, None, Some(build), &format!("{by} has seen to it")).await?;
        change.commit().await?;
        Ok(has_second)
    }

    /// Failed prints that nobody has seen to, oldest first. One whose owed copies are all printed again in other builds, or were, has
    /// been seen to.
    pub async fn unseen_failures(&self) -> Result<Vec<BuildRow>> {
        let query = sql::select_as(
            "FROM build WHERE state = 'failed' AND published_at IS NOT NULL AND seen_at IS NULL AND ( \
             NOT EXISTS (SELECT 1 FROM bad_placement bad WHERE bad.build_id = build.id AND bad.is_owed) \
             OR EXISTS (SELECT 1 FROM bad_placement bad WHERE bad.build_id = build.id AND bad.is_owed AND NOT EXISTS ( \
             SELECT 1 FROM placement again JOIN build later ON later.id = again.build_id \
             WHERE again.part_id = bad.part_id AND again.copy = bad.copy AND later.state IN ('printing', 'complete')))) ORDER BY id",
        );
        Ok(query.fetch_all(self.reader()?).await?)
    }
}

/// Records the reported outcome of a published build within a change, and changes its state, through printing if needed. Copies that
/// were printed badly (all of them if the print failed) wait again with all that was asked, unless told otherwise.
pub(crate) async fn tell_outcome(
    change: &mut LedgerChange,
    build: BuildId,
    told: &ToldOutcome,
) -> Result<PutBackReport> {
    if told.outcome == PrintOutcome::Failed && !told.bad.is_empty() {
        return Err(LedgerError::AllFailed);
    }
    let mut report = PutBackReport::default();
    move_to_outcome(change, build, told).await?;
    record_told(change, build, told).await?;
    let bad_before = told_bad(change, build).await?;
    if told.is_correction && told.outcome != PrintOutcome::Failed {
        change.return_bad_copies(build, &mut report).await?;
    }
    let bad_between = told_bad(change, build).await?;
    if told.outcome == PrintOutcome::Failed {
        let unseen = sql::query("UPDATE build SET seen_at = NULL WHERE id = $1").bind(build);
        unseen.execute(change.db()).await?;
    }
    let bad = match told.outcome {
        PrintOutcome::Failed => counted_copies(change, build).await?,
        _ => bad_copies(change, build, &told.bad).await?,
    };
    change.mark_bad(build, &bad, &told.told_by, !told.keep, &mut report).await?;
    let returned = bad_before.difference(&bad_between);
    let bad_after = told_bad(change, build).await?;
    for &(part, copy, was_owed) in returned {
        if let Some(is_owed) = [true, false].into_iter().find(|is_owed| bad_after.contains(&(part, copy, *is_owed))) {
            report.forget_return(part, was_owed == is_owed);
        }
    }
    let parts = counted_copies(change, build).await?.into_iter().map(|(part, _)| part);
    change.update_orders_of(parts.collect::<BTreeSet<_>>()).await?;
    Ok(report)
}

/// Writes down what somebody tells of a print.
pub(super) async fn record_told(change: &mut LedgerChange, build: BuildId, told: &ToldOutcome) -> Result<()> {
    let now = change.now;
    sql::query(
        "INSERT INTO outcome (build_id, outcome, note, told_by, told_at, is_correction) VALUES ($1, $2, $3, $4, $5, $6)",
    )
    .bind(build)
    .bind(told.outcome)
    .bind(&told.note)
    .bind(&told.told_by)
    .bind(now)
    .bind(told.is_correction)
    .execute(change.db())
    .await?;
    change.forget_dropped_word(build).await
}

/// Moves a build to the state of its outcome. A withdrawn build has none: its copies would count as printed, and be lost.
pub(super) async fn move_to_outcome(change: &mut LedgerChange, build: BuildId, told: &ToldOutcome) -> Result<()> {
    let (_, state) = change.require_build(build).await?;
    let query =
        sql::query_as("SELECT published_at IS NOT NULL, taken_at IS NOT NULL FROM build WHERE id = $1").bind(build);
    let (is_published, is_taken): (bool, bool) = query.fetch_one(change.db()).await?;
    let is_told = matches!(state, BuildState::Complete | BuildState::Interrupted | BuildState::Failed)
        || state == BuildState::Printing && told.outcome == PrintOutcome::Printing;
    if !is_published {
        // Only the farm may fail a nesting build, because it then releases the copies.
        change.ensure_build_state(build, REPORTABLE_STATES).await?;
    }
    if change.withdrawn_at(build).await?.is_some() {
        return Err(LedgerError::TakenBack(build));
    }
    if is_told && !told.is_correction {
        return Err(LedgerError::AlreadyTold { build, state, asked: told.outcome.build_state() });
    }
    if is_told && state == told.outcome.build_state() {
        return Ok(());
    }
    // Of a failed one whose file nobody is known to have taken, it is not said that it was printed.
    let was_printed = is_taken || told.outcome != PrintOutcome::Failed;
    if state == BuildState::Published && told.outcome != PrintOutcome::Printing && was_printed {
        change.move_build(build, BuildState::Printing, "").await?;
    }
    change.move_build(build, told.outcome.build_state(), &told.note).await?;
    Ok(())
}

/// What is said of an outcome that is about to be told.
pub(super) async fn outcome_sentence(change: &mut LedgerChange, build: BuildId, told: &ToldOutcome) -> Result<String> {
    let (_, state) = change.require_build(build).await?;
    Ok(match state == told.outcome.build_state() {
        true => format!("Build {build} stays {}, as it was told before.", told.outcome),
        false => format!("Build {build} is {}.", told.outcome),
    })
}

/// The copies of a build that were told bad, each with whether it is owed.
async fn told_bad(change: &mut LedgerChange, build: BuildId) -> Result<BTreeSet<(PartId, u32, bool)>> {
    let bad = sql::query_as("SELECT part_id, copy, is_owed FROM bad_placement WHERE build_id = $1").bind(build);
    let bad: Vec<(PartId, u32, bool)> = bad.fetch_all(change.db()).await?;
    Ok(bad.into_iter().collect())
}

/// The copies of a build that count.
pub(super) async fn counted_copies(change: &mut LedgerChange, build: BuildId) -> Result<Vec<(PartId, u32)>> {
    let copies = sql::query_as("SELECT part_id, copy FROM placement WHERE build_id = $1 ORDER BY part_id, copy");
    Ok(copies.bind(build).fetch_all(change.db()).await?)
}

/// The last copies of each named part in a build. Those that a restored ledger knows to have been printed again are among them.
async fn bad_copies(change: &mut LedgerChange, build: BuildId, named: &[(PartId, u32)]) -> Result<Vec<(PartId, u32)>> {
    let mut bad = Vec::new();
    for &(part, asked) in named {
        let mut copies: Vec<u32> =
            sql::query_scalar("SELECT copy FROM placement WHERE build_id = $1 AND part_id = $2 ORDER BY copy DESC")
                .bind(build)
                .bind(part)
                .fetch_all(change.db())
                .await?;
        let known = "SELECT count(*) FROM bad_placement WHERE build_id = $1 AND part_id = $2 AND told_by = $3";
        let known: u32 = sql::query_scalar(known)
            .bind(build)
            .bind(part)
            .bind(LedgerChange::TOLD_BY_RECORD)
            .fetch_one(change.db())
            .await?;
        let placed = copies.len() as u32 + known;
        if placed < asked {
            return Err(LedgerError::TooFewInBuild { part, build, asked, placed });
        }
        copies.truncate(asked.saturating_sub(known) as usize);
        bad.extend(copies.into_iter().map(|copy| (part, copy)));
    }
    Ok(bad)
}
