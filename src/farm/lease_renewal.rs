//! Renews the leases on the folders of every machine, at the start and at intervals.

use std::time::Duration;

use anyhow::Result;
use tracing::{info, warn};

use super::{
    adopt,
    alert::AlertKind,
    alert_registry::AlertRegistry,
    farm::Farm,
    folder_comparison,
    folder_lease::FolderLease,
    folder_leases::{FolderLeases, LeaseProblem},
    jobs::BackgroundJob,
    lease_clock,
    machine_state::MachineStates,
    tick_tasks::TimedTask,
};

/// The alert for each folder, in the order of [`FolderLeases::all_leases`].
const LEASE_ALERTS: [AlertKind; 4] =
    [AlertKind::HotFolderAway, AlertKind::QueueAway, AlertKind::ArchiveAway, AlertKind::ErrorFolderAway];

/// Renews the leases on a profile's folders; returns them with the error of each, and whether its queue folder is still
/// the one that was opened.
#[derive(Clone)]
pub(super) struct LeaseRenewalJob {
    profile: String,
}

impl BackgroundJob<Farm> for LeaseRenewalJob {
    const KIND: &'static str = "Lease";
    type Outcome = (Box<FolderLeases>, bool);

    fn subject(&self) -> String {
        self.profile.clone()
    }

    async fn on_done(self, farm: &mut Farm, (leases, is_same_queue): Self::Outcome) -> Result<()> {
        on_leases_renewed(farm, &self.profile, *leases, is_same_queue).await
    }
}

/// Acquires the leases on all folders. A folder that another daemon serves makes the start fail; an unavailable
/// folder is retried. Waits until it is clear whether other daemons named in markers are alive.
pub(super) fn acquire_leases_at_start(machines: &mut MachineStates, alerts: &mut AlertRegistry) -> Result<()> {
    let mut is_reported = false;
    loop {
        let mut unclear = None;
        for machine in machines.values_mut() {
            if !machine.leases.acquire_missing()? {
                let unclear_lease = |problem: &&LeaseProblem| matches!(problem, LeaseProblem::HolderUnclear(_));
                let problem = machine.leases.errors.iter().flatten().find(unclear_lease);
                unclear = problem.map(|problem| problem.text().to_owned());
            }
        }
        let Some(unclear) = unclear else { break };
        if !is_reported {
            info!("{unclear}; that takes up to {} s.", lease_clock::takeover_delay().as_secs());
        }
        is_reported = true;
        std::thread::sleep(Duration::from_secs(1));
    }
    for (name, machine) in machines {
        update_lease_alerts(alerts, name, &machine.leases);
    }
    Ok(())
}

/// Renews all leases when they are due, and at once those of a machine whose folders were not checked for too long.
/// Nothing is done with its parts meanwhile.
pub(super) fn renew_leases(farm: &mut Farm, is_due: bool) {
    if is_due {
        let (now, scan_secs) = (farm.now(), farm.settings.scan_secs);
        farm.schedule.tasks.record_done(TimedTask::RenewLeases, now, scan_secs);
    }
    for (name, machine) in farm.machines.iter().filter(|(_, s)| is_due || !s.leases.are_fresh()) {
        let (profile, mut leases) = (name.clone(), Box::new(machine.leases.clone()));
        let queue = machine.queue.opened.clone();
        farm.jobs.start(LeaseRenewalJob { profile }, move || {
            leases.renew_all();
            let is_same_queue = queue.is_none_or(|queue| queue.check_marker().is_ok());
            (leases, is_same_queue)
        });
    }
}

/// Takes in the renewed leases.
async fn on_leases_renewed(farm: &mut Farm, name: &str, leases: FolderLeases, is_same_queue: bool) -> Result<()> {
    // After a reload the folders may have changed.
    let Some(machine) = farm.machines.get_mut(name).filter(|s| s.leases.inbox.is_same_folder(&leases.inbox)) else {
        return Ok(());
    };
    update_lease_alerts(&mut farm.alerts, name, &leases);
    let (before, now) = (machine.leases.foreign_claims, leases.foreign_claims);
    let taken_over = leases.taken_over.clone();
    adopt::give_up_taken_over_claims(farm, name, &taken_over).await?;
    let mut is_interrupted = false;
    // The folders count as checked only from here on.
    if let Some(machine) = farm.machines.get_mut(name) {
        is_interrupted = machine.leases.interruption_count() != leases.interruption_count();
        if is_interrupted {
            // Another daemon, perhaps a copy of this farm, may have taken and printed the same parts: nothing is taken or
            // printed before the folders were compared with the ledger again.
            (machine.agreed_folders, machine.may_claim) = (None, false);
        }
        if !is_same_queue || !leases.can_publish() {
            // It is opened anew; until then nothing is nested for it.
            machine.queue.opened = None;
        }
        machine.leases = leases;
    }
    if is_interrupted {
        warn!(
            profile = name,
            "Another nestd may have served the folders of {name} meanwhile: they are compared with the ledger."
        );
        folder_comparison::start_folder_comparison(farm);
    }
    adopt::update_foreign_claims_alert(&mut farm.machines, &mut farm.alerts, name, before, now);
    Ok(())
}

/// Releases all leases. Whether another daemon serves the folders does not concern a farm that has stopped.
pub(super) fn release_leases(machines: &mut MachineStates, alerts: &mut AlertRegistry) {
    for (name, machine) in machines {
        machine.leases.all_leases().into_iter().for_each(FolderLease::release);
        alerts.clear(AlertKind::HeldByOther, name, "");
    }
}

fn update_lease_alerts(alerts: &mut AlertRegistry, name: &str, leases: &FolderLeases) {
    let mut held = Vec::new();
    for (kind, problem) in LEASE_ALERTS.into_iter().zip(&leases.errors) {
        if let Some(LeaseProblem::HeldByOther(why)) = problem {
            held.push(why.as_str());
        }
        match problem {
            Some(LeaseProblem::Unavailable(why)) => alerts.raise(kind, name, "lease", why),
            // Within seconds it is clear: nobody needs to act on it.
            Some(LeaseProblem::HolderUnclear(_) | LeaseProblem::HeldByOther(_)) | None => {
                alerts.clear(kind, name, "lease");
            }
        }
    }
    let is_unclear = leases.errors.iter().flatten().any(|problem| matches!(problem, LeaseProblem::HolderUnclear(_)));
    match held.first() {
        Some(why) => alerts.raise(AlertKind::HeldByOther, name, "", why),
        None if is_unclear => {}
        None => alerts.clear(AlertKind::HeldByOther, name, ""),
    }
}
