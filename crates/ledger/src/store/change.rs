//! A change of the ledger: one short immediate transaction. Every state transition of a row goes through this type,
//! together with its event.

use std::{collections::BTreeSet, path::PathBuf, sync::Arc};

use super::{
    consistency::{self, RuleScope},
    health,
    last_change::{self, LastChangeSeen},
};
use crate::{
    BuildId, BuildState, CommandId, EventKind, LedgerError, PartId, PartRow, PartState, RefusalCause, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, SqlTransaction},
    },
    rows::build_row::state_word,
};

/// A change that is not committed yet. Dropping it rolls everything back.
pub struct LedgerChange {
    transaction: SqlTransaction,
    /// The time used for everything in this change.
    pub now: UtcTimestamp,
    origin: ChangeOrigin,
    /// The commands that are done with this change.
    commands: CommandsDone,
    /// Number of the last event that this change wrote.
    last_event: i64,
    /// The machines that it concerns, whose nodes are told of it; none, or "" = all are.
    told: BTreeSet<String>,
    /// Whether nobody acts on it, unless it has an event.
    is_quiet: bool,
}

/// Commands that are carried out by one change.
#[derive(Debug, Clone, Default)]
pub struct CommandsDone {
    /// The commands.
    pub commands: Arc<[CommandId]>,
    /// The answer to them, "" = they get it later.
    pub answer: Arc<str>,
}

/// Where a change is made.
pub enum ChangeOrigin {
    /// In this file, whose last change is compared.
    File(PathBuf, Arc<LastChangeSeen>),
    /// On a server. A daemon's changes are counted, and its own are news to it at once.
    Server(Option<super::postgres::CountedChange>, super::postgres::ChangeNotices),
}

impl LedgerChange {
    /// Creates a change from a transaction that holds the write lock.
    pub fn new(transaction: SqlTransaction, now: UtcTimestamp, origin: ChangeOrigin, commands: CommandsDone) -> Self {
        Self { transaction, now, origin, commands, last_event: 0, told: BTreeSet::new(), is_quiet: false }
    }

    /// The connection to run queries on.
    pub fn db(&mut self) -> &mut SqlTransaction {
        &mut self.transaction
    }

    /// Commits the change.
    pub async fn commit(mut self) -> Result<()> {
        let CommandsDone { commands, answer } = std::mem::take(&mut self.commands);
        for command in commands.iter() {
            let done = sql::query(
                "UPDATE command SET state = 'done', answered_at = $1, answer = $2 WHERE id = $3 AND state = 'asked'",
            );
            let now = self.now;
            done.bind(now).bind(&*answer).bind(*command).execute(self.db()).await?;
        }
        if cfg!(debug_assertions) {
            let faults = consistency::find_inconsistencies(self.db(), &RuleScope::ALL).await?;
            debug_assert!(faults.is_empty(), "a change broke the ledger: {faults:?}");
        }
        match self.transaction {
            SqlTransaction::Sqlite(mut transaction) => {
                let counted = last_change::count_change(&mut transaction).await?;
                transaction.commit().await?;
                if let ChangeOrigin::File(file, seen) = &self.origin {
                    seen.record(counted);
                    health::note_changes(file, counted);
                }
            }
            SqlTransaction::Postgres(mut transaction, limit) => {
                let is_told = !(self.is_quiet && self.told.is_empty());
                if is_told {
                    sql::answered_within(limit, super::postgres::notify(&mut transaction, &self.told)).await?;
                }
                let committed = sql::answered_within(limit, transaction.commit()).await;
                committed.map_err(crate::ServerError::mark_unreachable)?;
                if let ChangeOrigin::Server(counted, notices) = self.origin {
                    counted.into_iter().for_each(super::postgres::CountedChange::confirm);
                    notices.count_own(is_told);
                }
            }
        }
        Ok(())
    }

    /// Reads a part within this change.
    pub async fn require_part(&mut self, id: PartId) -> Result<PartRow> {
        let part = sql::select_as("FROM part WHERE id = $1").bind(id).fetch_optional(self.db()).await?;
        part.ok_or(LedgerError::UnknownPart(id))
    }

    /// Reads machine and state of a build within this change.
    pub async fn require_build(&mut self, id: BuildId) -> Result<(String, BuildState)> {
        let query = sql::query_as("SELECT machine, state FROM build WHERE id = $1");
        query.bind(id).fetch_optional(self.db()).await?.ok_or(LedgerError::UnknownBuild(id))
    }

    /// Number of copies of a part that are in builds and count.
    pub async fn placed_count(&mut self, id: PartId) -> Result<u32> {
        let count = sql::query_scalar("SELECT count(*) FROM placement WHERE part_id = $1").bind(id);
        Ok(count.fetch_one(self.db()).await?)
    }

    /// Fails if a copy of the part is in a build that is not published yet.
    pub async fn ensure_not_being_built(&mut self, part: PartId) -> Result<()> {
        let nested: Option<(BuildId, BuildState)> = sql::query_as(
            "SELECT b.id, b.state FROM placement l JOIN build b ON b.id = l.build_id \
             WHERE l.part_id = $1 AND b.published_at IS NULL ORDER BY b.id LIMIT 1",
        )
        .bind(part)
        .fetch_optional(self.db())
        .await?;
        match nested {
            Some((build, state)) => Err(LedgerError::BeingBuilt { part, build, state }),
            None => Ok(()),
        }
    }

    /// Fails unless the build is in one of these states. Returns its machine.
    pub async fn ensure_build_state(&mut self, build: BuildId, needed: &'static [BuildState]) -> Result<String> {
        match self.require_build(build).await? {
            (machine, state) if needed.contains(&state) => Ok(machine),
            (_, state) => {
                let state = state_word(state, self.withdrawn_at(build).await?);
                Err(LedgerError::WrongState { build, state, needed })
            }
        }
    }

    /// When the file of a build was taken back out of the queue untouched; `None` = it was not.
    pub async fn withdrawn_at(&mut self, build: BuildId) -> Result<Option<UtcTimestamp>> {
        let query = sql::query_scalar("SELECT withdrawn_at FROM build WHERE id = $1").bind(build);
        Ok(query.fetch_one(self.db()).await?)
    }

    /// Moves a part to another state. `detail` is stored in the event.
    pub async fn move_part(&mut self, id: PartId, next: PartState, build: Option<BuildId>, detail: &str) -> Result<()> {
        let part = self.require_part(id).await?;
        self.move_known_part(&part, next, build, detail).await
    }

    /// Same as [`LedgerChange::move_part`] for a row that was read in this change.
    pub async fn move_known_part(
        &mut self,
        part: &PartRow,
        next: PartState,
        build: Option<BuildId>,
        detail: &str,
    ) -> Result<()> {
        self.set_part_state(part, next, None, "").await?;
        self.write_event(next, &part.machine, Some(part.id), build, detail).await
    }

    /// What kept these parts out of a build is gone: those that wait do so from now on, and a due build gathers after them.
    pub async fn begin_to_wait_again(&mut self, parts: &[PartId]) -> Result<()> {
        let now = self.now;
        for part in parts {
            let arrive = sql::query("UPDATE part SET state_at = $1 WHERE id = $2 AND state = 'waiting'");
            arrive.bind(now).bind(*part).execute(self.db()).await?;
        }
        Ok(())
    }

    /// Refuses a part. Its copies count as refused, unless a person cancelled it, it is no part, or a newer
    /// revision has taken over what is wanted.
    pub async fn refuse_part(&mut self, id: PartId, cause: RefusalCause, reason: &str) -> Result<()> {
        let reason = if reason.is_empty() { "no reason was given" } else { reason };
        let unwanted = match cause {
            RefusalCause::Replaced | RefusalCause::Cancelled | RefusalCause::Document => self.waiting_count(id).await?,
            _ => 0,
        };
        let part = self.require_part(id).await?;
        self.set_part_state(&part, PartState::Refused, Some(cause), reason).await?;
        self.change_cancelled(id, i64::from(unwanted)).await?;
        self.count_decision(id).await?;
        self.write_refusal_event(&part.machine, Some(id), cause, reason).await?;
        if unwanted > 0 {
            self.note_wanted_change(-i64::from(unwanted)).await?;
        }
        self.update_orders_of([id]).await
    }

    /// Sets the state of a part.
    async fn set_part_state(
        &mut self,
        part: &PartRow,
        next: PartState,
        cause: Option<RefusalCause>,
        reason: &str,
    ) -> Result<()> {
        let next = part.state.move_to(next)?;
        let now = self.now;
        sql::query("UPDATE part SET state = $1, state_at = $2, refusal = $3, reason = $4 WHERE id = $5")
            .bind(next)
            .bind(now)
            .bind(cause)
            .bind(reason)
            .bind(part.id)
            .execute(self.db())
            .await?;
        self.decide_awaiting(part.id).await
    }

    /// Moves a build to another state. `detail` is the reason of a failure and is stored in the event. Returns its
    /// machine.
    pub async fn move_build(&mut self, id: BuildId, next: BuildState, detail: &str) -> Result<String> {
        let (machine, state) = self.require_build(id).await?;
        let next = state.move_to(next)?;
        let now = self.now;
        sql::query(
            "UPDATE build SET state = $1, state_at = $2, \
             nesting_at = CASE $1 WHEN 'nesting' THEN coalesce(nesting_at, $2) ELSE nesting_at END, \
             verified_at = CASE $1 WHEN 'verified' THEN $2 ELSE verified_at END, \
             published_at = CASE $1 WHEN 'published' THEN $2 ELSE published_at END, \
             layout = CASE $1 WHEN 'nesting' THEN layout END, \
             reason = CASE WHEN $1 IN ('interrupted', 'complete', 'failed') THEN $3 ELSE reason END \
             WHERE id = $4",
        )
        .bind(next)
        .bind(now)
        .bind(detail)
        .bind(id)
        .execute(self.db())
        .await?;
        sql::query("DELETE FROM night_search WHERE build_id = $1").bind(id).execute(self.db()).await?;
        self.write_event(next, &machine, None, Some(id), detail).await?;
        Ok(machine)
    }

    /// Writes an event.
    pub async fn write_event(
        &mut self,
        kind: impl Into<EventKind>,
        machine: &str,
        part: Option<PartId>,
        build: Option<BuildId>,
        detail: &str,
    ) -> Result<()> {
        let now = self.now;
        let insert = sql::query_scalar(
            "INSERT INTO event (at, kind, machine, part_id, build_id, detail) VALUES ($1, $2, $3, $4, $5, $6) RETURNING id",
        );
        let insert = insert.bind(now).bind(kind.into()).bind(machine).bind(part).bind(build).bind(detail);
        self.last_event = insert.fetch_one(self.db()).await?;
        self.tell_node_of(machine);
        Ok(())
    }

    /// Has the node of a machine told of this change when it is committed.
    pub fn tell_node_of(&mut self, machine: &str) {
        self.told.insert(machine.to_owned());
    }

    /// Nobody acts on this change, unless it has an event.
    pub fn tell_nobody(&mut self) {
        self.is_quiet = true;
    }

    /// Adds to the last event by how many the copies wanted of its part changed.
    pub async fn note_wanted_change(&mut self, by: i64) -> Result<()> {
        let note = sql::query("UPDATE event SET wanted_change = $1 WHERE id = $2").bind(by).bind(self.last_event);
        note.execute(self.db()).await?;
        Ok(())
    }

    /// Writes the event of a refusal; without a part, the file was refused before it became one.
    pub async fn write_refusal_event(
        &mut self,
        machine: &str,
        part: Option<PartId>,
        cause: RefusalCause,
        reason: &str,
    ) -> Result<()> {
        self.write_caused_event(EventKind::Refused, machine, part, &cause.to_string(), reason).await
    }

    /// Writes an event with its cause, one word.
    pub async fn write_caused_event(
        &mut self,
        kind: EventKind,
        machine: &str,
        part: Option<PartId>,
        cause: &str,
        detail: &str,
    ) -> Result<()> {
        self.write_event(kind, machine, part, None, detail).await?;
        let cause = sql::query("UPDATE event SET cause = $1 WHERE id = $2").bind(cause).bind(self.last_event);
        cause.execute(self.db()).await?;
        Ok(())
    }
}
