//! Finishing: the steps that a part goes through after the print, and who says of each that it is done.

use build_file::finish_steps;
use schemars::JsonSchema;
use serde::Serialize;

use crate::{
    EventKind, Ledger, LedgerError, PartId, PartRow, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, sql_row},
    },
    store::change::LedgerChange,
};

/// A finishing step of a part.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct FinishingStep {
    /// Its name, as the finish of the part has it.
    pub step: String,
    /// Who said that it is done; `None` = nobody.
    pub done_by: Option<String>,
    /// When that was said.
    pub done_at: Option<UtcTimestamp>,
}

/// The finishing of a part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PartFinishing {
    /// The part.
    pub part: PartId,
    /// File name as dropped, with the name of its solid.
    pub name: String,
    /// Its steps, in their order.
    pub steps: Vec<FinishingStep>,
}

/// A step that somebody said is done.
struct FinishedStep {
    part_id: PartId,
    step: String,
    told_by: String,
    told_at: UtcTimestamp,
}

sql_row!(FinishedStep { part_id, step, told_by, told_at });

impl PartFinishing {
    fn new(part: &PartRow, done: &[FinishedStep]) -> Self {
        let step = |step: &str| {
            let said = done.iter().find(|row| row.part_id == part.id && row.step == step);
            FinishingStep {
                step: step.to_owned(),
                done_by: said.map(|row| row.told_by.clone()),
                done_at: said.map(|row| row.told_at),
            }
        };
        Self { part: part.id, name: part.full_name(), steps: finish_steps(&part.terms.finish).map(step).collect() }
    }
}

impl Ledger {
    /// The finishing of a part; no step where none is wanted.
    pub async fn finishing_of_part(&self, part: &PartRow) -> Result<PartFinishing> {
        let done = sql::select_as("FROM finished_step WHERE part_id = $1").bind(part.id);
        Ok(PartFinishing::new(part, &done.fetch_all(self.reader()?).await?))
    }

    /// The finishing of each part of an order of which some is wanted; not of those that were refused.
    pub async fn finishing_of_order(&self, order: &str) -> Result<Vec<PartFinishing>> {
        let parts = sql::select_as(
            "FROM part WHERE order_name = $1 AND order_name <> '' AND finish <> '' AND state <> 'refused' ORDER BY id",
        );
        let parts: Vec<PartRow> = parts.bind(order).fetch_all(self.reader()?).await?;
        let done = sql::select_as(
            "FROM finished_step WHERE part_id IN (SELECT id FROM part WHERE order_name = $1 AND order_name <> '')",
        );
        let done: Vec<FinishedStep> = done.bind(order).fetch_all(self.reader()?).await?;
        Ok(parts.iter().map(|part| PartFinishing::new(part, &done)).collect())
    }

    /// Says that a finishing step of a part is done, or that it is not. Returns whether that was not known.
    pub async fn tell_finished(&self, id: PartId, step: &str, is_done: bool, told_by: &str) -> Result<bool> {
        let mut change = self.begin_change().await?;
        let part = change.require_part(id).await?;
        let finish = &part.terms.finish;
        if !finish_steps(finish).any(|known| known == step) {
            let why = match finish.is_empty() {
                true => {
                    format!(
                        "part {id} has no finishing steps; `nestd edit {id} --finish '{step}'` gives it this one",
                        step = step.replace('\'', "'\\''")
                    )
                }
                false => format!("part {id} has no finishing step '{step}', only {finish}"),
            };
            return Err(LedgerError::UnusableTerm(why));
        }
        let is_printed: bool = sql::query_scalar(
            "SELECT EXISTS (SELECT 1 FROM placement l JOIN build b ON b.id = l.build_id WHERE l.part_id = $1 \
             AND (b.taken_at IS NOT NULL OR b.state IN ('printing', 'complete', 'interrupted')))",
        )
        .bind(id)
        .fetch_one(change.db())
        .await?;
        if is_done && !is_printed {
            return Err(LedgerError::UnusableTerm(format!(
                "no copy of part {id} is printed, so '{step}' cannot be done"
            )));
        }
        let changed = match is_done {
            true => sql::query(
                "INSERT INTO finished_step (part_id, step, told_by, told_at) VALUES ($1, $2, $3, $4) ON CONFLICT (part_id, step) DO NOTHING",
            )
            .bind(id)
            .bind(step)
            .bind(told_by)
            .bind(change.now),
            false => sql::query("DELETE FROM finished_step WHERE part_id = $1 AND step = $2").bind(id).bind(step),
        };
        if changed.execute(change.db()).await? == 0 {
            return Ok(false);
        }
        let what = if is_done { "is done" } else { "is not done" };
        let detail = format!("{told_by}: {step} {what}");
        change.write_event(EventKind::Finishing, &part.machine, Some(id), None, &detail).await?;
        change.commit().await?;
        Ok(true)
    }
}

impl LedgerChange {
    /// Copies of a part are to be made that nobody has finished: its steps are open again.
    pub(crate) async fn reopen_finishing(&mut self, id: PartId) -> Result<()> {
        let gone = sql::query("DELETE FROM finished_step WHERE part_id = $1").bind(id);
        if gone.execute(self.db()).await? > 0 {
            let machine = self.require_part(id).await?.machine;
            let detail = "more copies are made: its finishing steps are open again";
            self.write_event(EventKind::Finishing, &machine, Some(id), None, detail).await?;
        }
        Ok(())
    }

    /// What was told of steps that are no steps of a part any more is forgotten.
    pub(crate) async fn forget_other_steps(&mut self, id: PartId, finish: &str) -> Result<()> {
        let told: Vec<String> = sql::query_scalar("SELECT step FROM finished_step WHERE part_id = $1")
            .bind(id)
            .fetch_all(self.db())
            .await?;
        for step in told.iter().filter(|step| !finish_steps(finish).any(|known| known == step.as_str())) {
            let forget = sql::query("DELETE FROM finished_step WHERE part_id = $1 AND step = $2").bind(id).bind(step);
            forget.execute(self.db()).await?;
        }
        Ok(())
    }
}
