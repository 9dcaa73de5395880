//! What a published build becomes whose file was taken back untouched (`builds/take_back`) because its copies wait again.
//!
//! For the ledger, the print of a withdrawn build has failed and somebody has seen to it: whatever holds for the copies of a failed
//! print holds for its copies, also where a backup is put back.

use super::outcome::{counted_copies, record_told};
use crate::{
    BuildId, BuildState, EventKind, Ledger, PauseCause, PrintOutcome, PutBackReport, ToldOutcome,
    base::{error::Result, sql},
    builds::take_back::clear_way,
    store::change::LedgerChange,
};

/// Who withdraws a build that nobody asked for.
pub const WITHDRAWN_BY_NESTD: &str = "nestd";
/// Why a build is withdrawn of which a restored ledger knows only by its record.
pub(crate) const TAKEN_BACK_SINCE: &str = "taken back out of the queue untouched, as its record in the archive says";

impl Ledger {
    /// The outcome of a build was told while its file was on its way, which lay in no queue then: it is about to be removed.
    pub async fn record_dropped_move(&self, build: BuildId) -> Result<()> {
        let mut change = self.begin_change().await?;
        if change.require_build(build).await?.1 != BuildState::Published {
            record_untouched(&mut change, build).await?;
            change.commit().await?;
        }
        Ok(())
    }

    /// What was said of a build is not done, for its file could not be taken out of the queue: `why`, and what a person must look at. That
    /// is told until an outcome of the build is.
    pub async fn record_dropped_word(&self, build: BuildId, why: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        let set = sql::query("UPDATE build SET word_dropped = $1 WHERE id = $2").bind(why).bind(build);
        set.execute(change.db()).await?;
        change.commit().await
    }

    /// What was said of builds and was not done: the machine of each, and why; the oldest build first.
    pub async fn dropped_words(&self) -> Result<Vec<(String, String)>> {
        let query = "SELECT machine, word_dropped FROM build WHERE word_dropped IS NOT NULL ORDER BY id";
        Ok(sql::query_as(query).fetch_all(self.reader()?).await?)
    }

    /// The record of a published build says that its file was taken back untouched, which a ledger that was put back does not know: its
    /// copies wait again, and a word that waits for the file is over.
    pub async fn take_in_withdrawal(&self, build: BuildId) -> Result<()> {
        let mut change = self.begin_change().await?;
        put_withdrawn_back(&mut change, build, WITHDRAWN_BY_NESTD, TAKEN_BACK_SINCE).await?;
        clear_way(&mut change, build).await?;
        change.commit().await
    }

    /// The open build of a machine does not wait for the copies of a withdrawn build any more: none of them waits.
    pub async fn forget_withdrawn(&self, machine: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        let set = sql::query("UPDATE build SET takes_over = NULL WHERE machine = $1 AND state = 'open'").bind(machine);
        set.execute(change.db()).await?;
        change.commit().await
    }

    /// Whether originals of the parts of a withdrawn build are still being fetched.
    pub async fn awaits_originals_of(&self, build: BuildId) -> Result<bool> {
        let query = sql::query_scalar(
            "SELECT EXISTS (SELECT 1 FROM part WHERE state = 'waiting' AND fetch_at IS NOT NULL \
             AND id IN (SELECT part_id FROM bad_placement WHERE build_id = $1))",
        );
        Ok(query.bind(build).fetch_one(self.reader()?).await?)
    }

    /// The build that nestd withdrew for the open build of a machine; `None` = there is none.
    pub async fn withdrawn_for_open(&self, machine: &str) -> Result<Option<BuildId>> {
        let query = sql::query_scalar("SELECT takes_over FROM build WHERE machine = $1 AND state = 'open'");
        let build: Option<Option<BuildId>> = query.bind(machine).fetch_optional(self.reader()?).await?;
        Ok(build.flatten())
    }
}

/// The file of a published build was taken back: its copies wait again, in the place that they had in the order of precedence. Where nestd
/// itself withdrew it, the open build fires at once; where a person did, the machine is paused, so that the copies can be changed.
pub(crate) async fn withdraw(
    change: &mut LedgerChange,
    build: BuildId,
    by: &str,
    reason: &str,
) -> Result<PutBackReport> {
    let machine = change.ensure_build_state(build, &[BuildState::Published]).await?;
    let why = if reason.is_empty() { String::new() } else { format!(": {reason}") };
    let report = put_withdrawn_back(change, build, by, &format!("withdrawn from the queue by {by}{why}")).await?;
    if by == WITHDRAWN_BY_NESTD {
        let set = sql::query("UPDATE build SET takes_over = $1 WHERE machine = $2 AND state = 'open'");
        set.bind(build).bind(machine).execute(change.db()).await?;
    } else {
        change.pause_machine(&machine, by, PauseCause::Person).await?;
    }
    Ok(report)
}

/// published -> failed: all copies of a build that nobody printed wait again, as they did before it.
pub(crate) async fn put_withdrawn_back(
    change: &mut LedgerChange,
    build: BuildId,
    by: &str,
    note: &str,
) -> Result<PutBackReport> {
    record_withdrawn(change, build, by, note).await?;
    let mut report = PutBackReport::default();
    let copies = counted_copies(change, build).await?;
    change.mark_bad(build, &copies, by, true, &mut report).await?;
    let now = change.now;
    // They were not printed badly: they do not go before what is more urgent.
    let usual = sql::query(
        "UPDATE part SET put_back_at = NULL WHERE put_back_at = $1 \
         AND id IN (SELECT part_id FROM bad_placement WHERE build_id = $2)",
    );
    usual.bind(now).bind(build).execute(change.db()).await?;
    Ok(report)
}

/// published -> failed: its file was taken back out of the queue, and nobody printed it.
pub(super) async fn record_withdrawn(change: &mut LedgerChange, build: BuildId, by: &str, note: &str) -> Result<()> {
    let machine = change.ensure_build_state(build, &[BuildState::Published]).await?;
    let told = ToldOutcome::new(PrintOutcome::Failed, note, by);
    change.move_build(build, BuildState::Failed, note).await?;
    record_told(change, build, &told).await?;
    record_untouched(change, build).await?;
    change.write_event(EventKind::Withdrawn, &machine, None, Some(build), note).await
}

/// The file of a build of which an outcome was told is out of the queue, where it had lain untouched. Where nobody told anything but
/// that the print failed, nobody printed it: it is withdrawn, and never counts as printed. Of any other build, a file that comes back
/// is told of.
pub(super) async fn record_untouched(change: &mut LedgerChange, build: BuildId) -> Result<()> {
    let now = change.now;
    let set = sql::query(
        "UPDATE build SET withdrawn_at = $1, seen_at = $1 WHERE id = $2 AND state = 'failed' AND taken_at IS NULL \
         AND withdrawn_at IS NULL AND NOT EXISTS (SELECT 1 FROM outcome WHERE build_id = $2 AND outcome <> 'failed')",
    );
    if set.bind(now).bind(build).execute(change.db()).await? == 0 {
        let set = "UPDATE build SET taken_at = coalesce(taken_at, $1) WHERE id = $2 AND withdrawn_at IS NULL";
        sql::query(set).bind(now).bind(build).execute(change.db()).await?;
    }
    Ok(())
}
