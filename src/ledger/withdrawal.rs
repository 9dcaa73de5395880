//! A published build that its printer has not taken can be withdrawn. Each step is recorded before the disk is changed, so
//! that after a crash the file shows what happened:
//!
//! 1. `begin_withdrawal`. The file is taken back by one rename; if it is not there, its printer took it (`end_withdrawal`).
//! 2. `finish_withdrawal`: its copies wait again, with all that was asked. From now on the file is not wanted.
//! 3. What was taken back is removed. `end_withdrawal`.
//!
//! For the ledger, the print of a withdrawn build has failed and somebody has seen to it: whatever holds for the copies of a failed
//! print holds for its copies, also where a backup is put back.

use super::{
    BuildId, BuildRow, BuildState, EventKind, Ledger, LedgerError, PrintOutcome, PutBackReport, ToldOutcome,
    error::Result,
    outcome::{counted_copies, move_to_outcome, record_told},
    sql,
};

/// Who withdraws a build that nobody asked for.
pub const WITHDRAWN_BY_NESTD: &str = "nestd";

impl Ledger {
    /// The builds of a machine whose files are to be taken back.
    pub async fn builds_to_withdraw(&self, profile: &str) -> Result<Vec<BuildRow>> {
        let query = sql::select_as("FROM build WHERE withdraw_by IS NOT NULL AND profile = $1 ORDER BY id");
        Ok(query.bind(profile).fetch_all(self.reader()?).await?)
    }

    /// The file of a published build is about to be taken back out of the queue. Asking again changes nothing.
    ///
    /// `WrongState` unless it is published; `NotInQueue` if its printer has taken it, or it is on its way to another one.
    pub async fn begin_withdrawal(&self, build: BuildId, by: &str, reason: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        let profile = change.ensure_build_state(build, &[BuildState::Published]).await?;
        let set = sql::query(
            "UPDATE build SET withdraw_by = coalesce(withdraw_by, $1), withdraw_reason = coalesce(withdraw_reason, $2) \
             WHERE id = $3 AND taken_at IS NULL AND move_to IS NULL",
        );
        if set.bind(by).bind(reason).bind(build).execute(change.db()).await? == 0 {
            return Err(LedgerError::NotInQueue(build));
        }
        let why = if reason.is_empty() { String::new() } else { format!(": {reason}") };
        let detail = format!("{by} wants its file back{why}");
        change.write_event(EventKind::Withdrawn, &profile, None, Some(build), &detail).await?;
        change.commit().await
    }

    /// The file of a build was taken back: its copies wait again. Where nestd itself withdrew it, the open build fires at once.
    /// Returns `None`, and changes nothing, if the outcome of the build was told meanwhile.
    pub async fn finish_withdrawal(&self, build: BuildId) -> Result<Option<PutBackReport>> {
        let mut change = self.begin_change().await?;
        let (profile, state) = change.require_build(build).await?;
        let asked = sql::query_as("SELECT withdraw_by, coalesce(withdraw_reason, '') FROM build WHERE id = $1");
        let (by, reason): (Option<String>, String) = asked.bind(build).fetch_one(change.db()).await?;
        let Some(by) = by.filter(|_| state == BuildState::Published) else { return Ok(None) };
        let why = if reason.is_empty() { String::new() } else { format!(": {reason}") };
        let told = ToldOutcome::new(PrintOutcome::Failed, &format!("withdrawn from the queue by {by}{why}"), &by);
        move_to_outcome(&mut change, build, &told).await?;
        record_told(&mut change, build, &told).await?;
        let mut report = PutBackReport::default();
        let copies = counted_copies(&mut change, build).await?;
        change.mark_bad(build, &copies, &by, true, &mut report).await?;
        let now = change.now;
        let set = sql::query("UPDATE build SET withdrawn_at = $1, seen_at = $1 WHERE id = $2");
        set.bind(now).bind(build).execute(change.db()).await?;
        if by == WITHDRAWN_BY_NESTD {
            let set = sql::query("UPDATE build SET takes_over = $1 WHERE profile = $2 AND state = 'open'");
            set.bind(build).bind(profile).execute(change.db()).await?;
        }
        change.commit().await?;
        Ok(Some(report))
    }

    /// Nothing of a withdrawal is left to do.
    pub async fn end_withdrawal(&self, build: BuildId, end: WithdrawalEnd) -> Result<()> {
        let mut change = self.begin_change().await?;
        let (profile, _) = change.require_build(build).await?;
        let now = change.now;
        if end == WithdrawalEnd::Taken {
            let set = sql::query("UPDATE build SET taken_at = coalesce(taken_at, $1) WHERE id = $2");
            set.bind(now).bind(build).execute(change.db()).await?;
            let detail = "its printer took the file first: the build stays";
            change.write_event(EventKind::Withdrawn, &profile, None, Some(build), detail).await?;
        }
        let set = sql::query("UPDATE build SET withdraw_by = NULL, withdraw_reason = NULL WHERE id = $1").bind(build);
        set.execute(change.db()).await?;
        change.commit().await
    }

    /// The build that nestd withdrew for the open build of a machine; `None` = there is none.
    pub async fn withdrawn_for_open(&self, profile: &str) -> Result<Option<BuildId>> {
        let query = sql::query_scalar("SELECT takes_over FROM build WHERE profile = $1 AND state = 'open'");
        let build: Option<Option<BuildId>> = query.bind(profile).fetch_optional(self.reader()?).await?;
        Ok(build.flatten())
    }
}

/// How a withdrawal ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WithdrawalEnd {
    /// The printer took the file before it could be taken back.
    Taken,
    /// The file is in no queue folder, or was told to be printed.
    Removed,
}
