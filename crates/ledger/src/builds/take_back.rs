//! The way of a published file that is taken back out of the queue of its printer. The build stays published meanwhile. Each step is
//! recorded before the disk is changed, so that after a crash the files show what happened:
//!
//! 1. Its target is noted: a word, whose copies wait again (`words/operator_word`), or another printer (`begin_move`). The file is taken
//!    back by one rename; if it is not there, its printer took it (`end_take_back`).
//! 2. For a word, that is carried out: from now on the file is not wanted. For another printer, the file is staged in the other queue
//!    (`record_move`): from now on, it may be visible there.
//! 3. What was taken back is removed. For a word, nothing is left to do (`end_take_back`). For another printer, what is staged becomes
//!    visible (`finish_move`).
//!
//! Where the outcome is told during a move, the file goes out of both queues (`end_take_back`).

use crate::{
    BuildId, BuildRow, BuildState, EventKind, Ledger,
    base::{error::Result, sql},
    store::change::LedgerChange,
};

/// The builds of a machine whose files are taken back for a word, those that go to another printer, and those that lie in the queue of a
/// printer that is down. No build is two of these.
const TAKEN_BACK: [&str; 3] = [
    "FROM build WHERE withdraw_by IS NOT NULL AND machine = $1 ORDER BY id",
    "FROM build WHERE move_to IS NOT NULL AND machine = $1 ORDER BY id",
    "FROM build WHERE machine = $1 AND state = 'published' AND taken_at IS NULL AND printer IS NOT NULL \
     AND move_to IS NULL AND withdraw_by IS NULL AND printer IN (SELECT printer FROM printer_down WHERE machine = $1) ORDER BY id",
];

impl Ledger {
    /// The builds whose files are being taken back, or lie in the queue of a printer that is down.
    pub async fn builds_to_take_back(&self, machine: &str) -> Result<Vec<BuildRow>> {
        let mut builds = Vec::new();
        for query in TAKEN_BACK {
            builds.extend(sql::select_as(query).bind(machine).fetch_all(self.reader()?).await?);
        }
        Ok(builds)
    }

    /// The file of a published build is about to be taken back, for another printer.
    pub async fn begin_move(&self, build: BuildId, to: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.ensure_build_state(build, &[BuildState::Published]).await?;
        // Another printer may be chosen as long as the file may not be visible at the one that was chosen.
        let set = sql::query(
            "UPDATE build SET move_to = $1 WHERE id = $2 AND taken_at IS NULL AND move_queue_id IS NULL \
             AND withdraw_by IS NULL",
        );
        set.bind(to).bind(build).execute(change.db()).await?;
        change.commit().await
    }

    /// The file that was taken back is complete in the queue folder of a printer, with this marker: from now on it may be visible there.
    pub async fn record_move(&self, build: BuildId, to: &str, queue_id: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.ensure_build_state(build, &[BuildState::Published]).await?;
        let set = sql::query("UPDATE build SET move_to = $1, move_queue_id = $2 WHERE id = $3 AND move_to IS NOT NULL");
        set.bind(to).bind(queue_id).bind(build).execute(change.db()).await?;
        change.commit().await
    }

    /// The file is visible in the other queue folder, or was. Returns `false`, and changes nothing, if the outcome of the
    /// build was told meanwhile: then the file is not wanted there.
    pub async fn finish_move(&self, build: BuildId) -> Result<bool> {
        let mut change = self.begin_change().await?;
        let (machine, from, to) = printers_of(&mut change, build).await?;
        let set = "UPDATE build SET printer = move_to, queue_id = move_queue_id, move_to = NULL, move_queue_id = NULL \
            WHERE id = $1 AND move_queue_id IS NOT NULL AND state = 'published'";
        if sql::query(set).bind(build).execute(change.db()).await? == 0 {
            return Ok(false);
        }
        let (from, to) = (from.unwrap_or_default(), to.unwrap_or_default());
        let detail = if from == to { format!("back in the queue of {to}") } else { format!("from {from} to {to}") };
        change.write_event(EventKind::Relocated, &machine, None, Some(build), &detail).await?;
        change.commit().await?;
        Ok(true)
    }

    /// The file is on its way no more: nothing of it is left to do, and no word waits for it.
    pub async fn end_take_back(&self, build: BuildId, end: TakeBackEnd) -> Result<()> {
        let mut change = self.begin_change().await?;
        let (now, state) = (change.now, change.require_build(build).await?.1);
        let (machine, from, to) = printers_of(&mut change, build).await?;
        let (is_word, from, to) = (to.is_none(), from.unwrap_or_default(), to.unwrap_or_default());
        let set = match end {
            TakeBackEnd::Taken => "UPDATE build SET taken_at = coalesce(taken_at, $1) WHERE id = $2",
            TakeBackEnd::TakenThere => {
                "UPDATE build SET taken_at = $1, printer = coalesce(move_to, printer), \
                 queue_id = coalesce(move_queue_id, queue_id) WHERE id = $2"
            }
            TakeBackEnd::Altered | TakeBackEnd::Copied(_) | TakeBackEnd::Removed => "",
        };
        if !set.is_empty() {
            sql::query(set).bind(now).bind(build).execute(change.db()).await?;
        }
        let told = match end {
            TakeBackEnd::Taken if is_word && state == BuildState::Published => {
                Some((EventKind::Withdrawn, "not taken back: its printer took the file first".to_owned()))
            }
            TakeBackEnd::Altered if is_word => {
                let detail = "not taken back: what lies in the queue is not the file that was proved";
                Some((EventKind::Withdrawn, detail.to_owned()))
            }
            TakeBackEnd::Copied(places) => {
                Some((EventKind::Withdrawn, format!("not taken back: its copies lie in the queue as {places}")))
            }
            TakeBackEnd::TakenThere => Some((EventKind::Relocated, format!("from {from} to {to}, which took it"))),
            _ => None,
        };
        if let Some((kind, detail)) = told {
            change.write_event(kind, &machine, None, Some(build), &detail).await?;
        }
        clear_way(&mut change, build).await?;
        change.commit().await
    }

    /// The file of a published build was found where the ledger does not have it, as after a backup was put back: at `found`.
    /// Nothing is recorded if the build moves, or is no longer where the ledger had it.
    pub async fn correct_place(&self, build: BuildId, found: &FoundPlace) -> Result<()> {
        let mut change = self.begin_change().await?;
        let (machine, from, _) = printers_of(&mut change, build).await?;
        // A file that was taken back is brought to a printer, beginning with the one where it is.
        let move_to = found.is_taken_back.then(|| found.printer.clone());
        let set = sql::query(
            "UPDATE build SET printer = $1, queue_id = $2, move_to = $3, taken_at = NULL WHERE id = $4 AND state = 'published' \
             AND move_to IS NULL AND withdraw_by IS NULL AND queue_id IS NOT DISTINCT FROM $5",
        );
        let set =
            set.bind(&found.printer).bind(&found.queue_id).bind(move_to).bind(build).bind(found.instead_of.clone());
        if set.execute(change.db()).await? == 0 {
            return Ok(());
        }
        let what = if found.is_taken_back { "found taken back at" } else { "found at" };
        let detail = format!("{what} {} instead of {}", found.printer, from.unwrap_or_default());
        change.write_event(EventKind::Found, &machine, None, Some(build), &detail).await?;
        change.commit().await
    }
}

/// How it ended that a file was to be taken back.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TakeBackEnd {
    /// Its printer took the file before it could be taken back.
    Taken,
    /// The outcome was told while it moved, and the other printer has taken the file.
    TakenThere,
    /// What lies there is not the proved file.
    Altered,
    /// Its copies lie in a queue under another name, or a second time: where.
    Copied(String),
    /// The file is not in the queue where the ledger has it: it was taken back, or found elsewhere.
    Removed,
}

/// Where the file of a published build was found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FoundPlace {
    /// The printer in whose queue folder it is.
    pub printer: String,
    /// Marker of that folder.
    pub queue_id: String,
    /// Marker of the folder where the ledger had it.
    pub instead_of: Option<String>,
    /// Whether it is there as a file that was taken back.
    pub is_taken_back: bool,
}

/// The machine of a build, its printer, and the one that it is moved to.
async fn printers_of(change: &mut LedgerChange, build: BuildId) -> Result<(String, Option<String>, Option<String>)> {
    let query = sql::query_as("SELECT machine, printer, move_to FROM build WHERE id = $1").bind(build);
    Ok(query.fetch_one(change.db()).await?)
}

/// The file of a build is on its way nowhere, and no word waits for it any more.
pub(crate) async fn clear_way(change: &mut LedgerChange, build: BuildId) -> Result<()> {
    let set = "UPDATE build SET move_to = NULL, move_queue_id = NULL, \
        withdraw_by = NULL, withdraw_reason = NULL, withdraw_word = NULL WHERE id = $1";
    sql::query(set).bind(build).execute(change.db()).await?;
    Ok(())
}
