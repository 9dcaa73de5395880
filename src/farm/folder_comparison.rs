//! Compares the folders of every machine with the ledger while the farm runs.

use std::sync::Arc;

use anyhow::Result;

use super::{
    alert::AlertKind,
    farm::Farm,
    jobs::BackgroundJob,
    ledger_freshness::{FolderComparison, StoreComparison, compare_machine_folders},
};

/// Compares a profile's folders with the ledger.
#[derive(Clone)]
pub(super) struct FolderComparisonJob {
    profile: String,
}

impl BackgroundJob<Farm> for FolderComparisonJob {
    const KIND: &'static str = "Compare";
    type Outcome = FolderComparison;

    fn subject(&self) -> String {
        self.profile.clone()
    }

    async fn on_done(self, farm: &mut Farm, compared: Self::Outcome) -> Result<()> {
        on_folders_compared(farm, &self.profile, compared);
        Ok(())
    }
}

/// Starts to compare the folders of every machine with the ledger. Until they agree, nothing is printed; if they
/// disagree, nothing is claimed.
pub(super) fn start_folder_comparison(farm: &mut Farm) {
    // Each machine has a job of its own, because its folders may hang.
    let store = Arc::new(StoreComparison::default());
    for (name, machine) in &farm.machines {
        let store = store.clone();
        let (settings, ledger, profile) = (farm.settings.clone(), farm.ledger.clone(), machine.profile.clone());
        let (before, runtime) = (machine.agreed_folders, tokio::runtime::Handle::current());
        farm.jobs.start(FolderComparisonJob { profile: name.clone() }, move || {
            runtime.block_on(compare_machine_folders(&settings, &ledger, &store, &profile, before))
        });
    }
}

/// Takes in the result.
fn on_folders_compared(farm: &mut Farm, name: &str, compared: FolderComparison) {
    let Some(machine) = farm.machines.get_mut(name) else { return };
    let (behind, away) = match compared {
        FolderComparison::Unchanged => return,
        FolderComparison::LedgerCurrent(seen) => {
            machine.agreed_folders = Some(seen);
            machine.next_batch_at = farm.schedule.time.instant();
            (None, None)
        }
        FolderComparison::LedgerBehind(detail) => (Some(detail), None),
        FolderComparison::Unavailable(why) => (None, Some(why)),
    };
    machine.may_claim = behind.is_none();
    if behind.is_some() || away.is_some() {
        machine.agreed_folders = None;
    }
    for (kind, detail) in [(AlertKind::LedgerBehind, behind), (AlertKind::FoldersMissing, away)] {
        match detail {
            Some(detail) => farm.alerts.raise(kind, name, "comparison", &detail),
            None => farm.alerts.clear(kind, name, "comparison"),
        }
    }
}
