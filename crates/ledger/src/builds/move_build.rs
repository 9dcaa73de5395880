//! The way of a published file from the queue folder of one printer to that of another. The build stays published
//! meanwhile. Each step is recorded before the disk is changed, so that after a crash the files show what happened:
//!
//! 1. `begin_move`. The file is taken back by one rename; if it is not there, its printer took it (`end_move`).
//! 2. It is copied under a dot-name into the other folder. `record_move`: from now on, it may be visible there.
//! 3. What was taken back is removed, then the dot-file is renamed. `finish_move`.
//!
//! Where the outcome is told meanwhile, the file goes out of both folders (`end_move`).

use crate::{
    BuildId, BuildRow, BuildState, EventKind, Ledger,
    base::{error::Result, sql},
    store::change::LedgerChange,
};

impl Ledger {
    /// The builds whose files are being moved, or lie in the queue of a printer that is down.
    pub async fn builds_to_move(&self, profile: &str) -> Result<Vec<BuildRow>> {
        let moving = sql::select_as("FROM build WHERE move_to IS NOT NULL AND profile = $1 ORDER BY id").bind(profile);
        let mut builds: Vec<BuildRow> = moving.fetch_all(self.reader()?).await?;
        let left = sql::select_as(
            "FROM build WHERE profile = $1 AND state = 'published' AND taken_at IS NULL AND printer IS NOT NULL \
             AND move_to IS NULL AND withdraw_by IS NULL AND printer IN (SELECT printer FROM printer_down WHERE profile = $1) ORDER BY id",
        );
        builds.extend(left.bind(profile).fetch_all(self.reader()?).await?);
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

    /// The file that was taken back is complete in the queue folder with this marker: from now on it may be visible there.
    pub async fn record_move(&self, build: BuildId, queue_id: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.ensure_build_state(build, &[BuildState::Published]).await?;
        let set = sql::query("UPDATE build SET move_queue_id = $1 WHERE id = $2 AND move_to IS NOT NULL");
        set.bind(queue_id).bind(build).execute(change.db()).await?;
        change.commit().await
    }

    /// The file is visible in the other queue folder, or was. Returns `false`, and changes nothing, if the outcome of the
    /// build was told meanwhile: then the file is not wanted there.
    pub async fn finish_move(&self, build: BuildId) -> Result<bool> {
        let mut change = self.begin_change().await?;
        let (profile, from, to) = printers_of(&mut change, build).await?;
        let set = "UPDATE build SET printer = move_to, queue_id = move_queue_id, move_to = NULL, move_queue_id = NULL \
            WHERE id = $1 AND move_queue_id IS NOT NULL AND state = 'published'";
        if sql::query(set).bind(build).execute(change.db()).await? == 0 {
            return Ok(false);
        }
        let detail = format!("from {} to {}", from.unwrap_or_default(), to.unwrap_or_default());
        change.write_event(EventKind::Relocated, &profile, None, Some(build), &detail).await?;
        change.commit().await?;
        Ok(true)
    }

    /// The file is not moved after all.
    pub async fn end_move(&self, build: BuildId, end: MoveEnd) -> Result<()> {
        let mut change = self.begin_change().await?;
        let (now, (profile, from, to)) = (change.now, printers_of(&mut change, build).await?);
        let set = match end {
            MoveEnd::Taken => {
                let set = "UPDATE build SET taken_at = coalesce(taken_at, $2), move_to = NULL, move_queue_id = NULL WHERE id = $1";
                sql::query(set).bind(build).bind(now)
            }
            MoveEnd::Dropped => {
                sql::query("UPDATE build SET move_to = NULL, move_queue_id = NULL WHERE id = $1").bind(build)
            }
            MoveEnd::TakenThere => {
                let set = "UPDATE build SET taken_at = $2, printer = coalesce(move_to, printer), \
                    queue_id = coalesce(move_queue_id, queue_id), move_to = NULL, move_queue_id = NULL WHERE id = $1";
                sql::query(set).bind(build).bind(now)
            }
        };
        set.execute(change.db()).await?;
        if end == MoveEnd::TakenThere {
            let detail = format!("from {} to {}, which took it", from.unwrap_or_default(), to.unwrap_or_default());
            change.write_event(EventKind::Relocated, &profile, None, Some(build), &detail).await?;
        }
        change.commit().await
    }

    /// The file of a published build was found where the ledger does not have it, as after a backup was put back: at `found`.
    /// Nothing is recorded if the build moves, or is no longer where the ledger had it.
    pub async fn correct_place(&self, build: BuildId, found: &FoundPlace) -> Result<()> {
        let mut change = self.begin_change().await?;
        let (profile, from, _) = printers_of(&mut change, build).await?;
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
        change.write_event(EventKind::Relocated, &profile, None, Some(build), &detail).await?;
        change.commit().await
    }
}

/// How a move ended that did not bring the file to another printer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MoveEnd {
    /// Its printer took the file before it could be taken back.
    Taken,
    /// The outcome was told meanwhile, and the file is in no queue.
    Dropped,
    /// The outcome was told meanwhile, and the other printer has taken the file.
    TakenThere,
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
    let query = sql::query_as("SELECT profile, printer, move_to FROM build WHERE id = $1").bind(build);
    Ok(query.fetch_one(change.db()).await?)
}
