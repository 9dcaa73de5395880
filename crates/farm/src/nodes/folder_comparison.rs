//! Compares the folders of every machine with the ledger while the farm runs.

use std::sync::Arc;

use anyhow::Result;
use jobs::BackgroundJob;

use crate::{
    alerts::alert::AlertKind,
    core::{desks::Serving, farm::Farm},
    records::ledger_freshness::{FolderComparison, StoreComparison, compare_machine_folders},
};

/// Compares a machine's folders with the ledger.
#[derive(Clone)]
pub(crate) struct FolderComparisonJob {
    machine: String,
    /// Count of the interruptions of the leases when it began: what was compared before a later one says nothing.
    interruptions: u32,
}

impl BackgroundJob<Farm> for FolderComparisonJob {
    const KIND: &'static str = "Compare";
    const IS_LOOK: bool = true;
    type Outcome = FolderComparison;
    type Desk<'f> = Serving<'f>;

    fn subject(&self) -> String {
        self.machine.clone()
    }

    async fn on_done(self, mut desk: Self::Desk<'_>, compared: Self::Outcome) -> Result<()> {
        let leases = desk.machines.get(&self.machine).map(|machine| &machine.leases);
        match leases.is_some_and(|leases| leases.interruption_count() != self.interruptions) {
            true => start_folder_comparison(&mut desk),
            false => on_folders_compared(&mut desk, &self.machine, compared),
        }
        Ok(())
    }
}

/// Starts to compare the folders of every machine with the ledger. Until they agree, nothing is printed; if they
/// disagree, nothing is claimed.
pub(crate) fn start_folder_comparison(desk: &mut Serving<'_>) {
    // Each machine has a job of its own, because its folders may hang.
    let store = Arc::new(StoreComparison::default());
    for (name, machine) in desk.machines.iter() {
        let store = store.clone();
        let (settings, ledger, machine_name) =
            (desk.shared.settings.clone(), desk.shared.ledger.clone(), machine.profile.clone());
        let interruptions = machine.leases.interruption_count();
        let (before, runtime) = (machine.agreed_folders.clone(), tokio::runtime::Handle::current());
        desk.jobs.start(FolderComparisonJob { machine: name.clone(), interruptions }, move || {
            runtime.block_on(compare_machine_folders(&settings, &ledger, &store, &machine_name, before))
        });
    }
}

/// Takes in the result.
fn on_folders_compared(desk: &mut Serving<'_>, name: &str, compared: FolderComparison) {
    let Some(machine) = desk.machines.get_mut(name) else { return };
    let is_behind = desk.shared.alerts.is_active(AlertKind::LedgerBehind, name, "comparison");
    let is_away = match &compared {
        FolderComparison::FolderAway => true,
        // What the folder of one printer held is not settled by its absence.
        FolderComparison::LedgerCurrent(seen) => is_behind && !seen.has_all_queues(&machine.profile),
        _ => false,
    };
    if is_away && is_behind {
        machine.agreed_folders = None;
        return;
    }
    let (behind, unreadable) = match compared {
        FolderComparison::Unchanged => return,
        FolderComparison::FolderAway => (None, None),
        FolderComparison::LedgerCurrent(seen) => {
            machine.agreed_folders = Some(seen);
            machine.pacing.next_batch_at = desk.shared.now();
            (None, None)
        }
        FolderComparison::LedgerBehind(detail) => (Some(detail), None),
        FolderComparison::Unavailable(why) => (None, Some(why)),
    };
    machine.may_claim = behind.is_none();
    if behind.is_some() || unreadable.is_some() || is_away {
        machine.agreed_folders = None;
    }
    for (kind, detail) in [(AlertKind::LedgerBehind, behind), (AlertKind::ArchiveAway, unreadable)] {
        match detail {
            Some(detail) => desk.shared.alerts.raise(kind, name, "comparison", &detail),
            None => desk.shared.alerts.clear(kind, name, "comparison"),
        }
    }
}
