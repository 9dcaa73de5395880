//! Renews the leases on the folders of every machine, at the start and at intervals.

use std::time::Duration;

use anyhow::Result;
use delivery::queue::QueueAddress;
use jobs::{BackgroundJob, Carried};
use tracing::{info, warn};

use super::{adopt, folder_comparison};
use crate::{
    alerts::{alert::AlertKind, alert_registry::AlertRegistry},
    core::{
        desks::{Batching, Serving},
        farm::Farm,
        machine_state::{MachineState, MachineStates},
        printer_state::{MachinePrinters, PrinterState, alert_subject},
    },
    leases::{
        folder_lease::FolderLease,
        folder_leases::{FolderLeases, LeaseProblem},
        lease_clock,
    },
    process::tick_tasks::TimedTask,
};

/// The alert for each folder before the queue folders, in the order of [`FolderLeases::all_leases`].
const LEASE_ALERTS: [AlertKind; 3] = [AlertKind::HotFolderAway, AlertKind::ArchiveAway, AlertKind::ErrorFolderAway];

/// Renews the leases on a machine's folders.
#[derive(Clone)]
pub(crate) struct LeaseRenewalJob {
    machine: String,
}

impl BackgroundJob<Farm> for LeaseRenewalJob {
    const KIND: &'static str = "Lease";
    const IS_LOOK: bool = true;
    type Outcome = ();
    type Desk<'f> = Batching<'f>;

    fn subject(&self) -> String {
        self.machine.clone()
    }

    async fn on_done(self, mut desk: Self::Desk<'_>, (): ()) -> Result<()> {
        on_leases_renewed(&mut desk, &self.machine).await
    }
}

/// The leases of a machine that a job renews. The farm must know each beat that is in the markers, or it would take its own for that of
/// another daemon.
struct CarriedLeases {
    machine: String,
    leases: Box<FolderLeases>,
    /// The queues that are not those that were opened.
    replaced: Vec<QueueAddress>,
}

impl Carried<Farm> for CarriedLeases {
    type Desk<'f> = Serving<'f>;

    fn give_back(self, mut desk: Self::Desk<'_>) {
        let Self { machine: name, leases, replaced } = self;
        // After a reload the folders may have changed.
        let is_same = |machine: &&mut MachineState| machine.leases.are_of_same_folders(&leases);
        let Some(machine) = desk.machines.get_mut(&name).filter(is_same) else { return };
        update_lease_alerts(desk.shared.alerts, &name, &machine.printers, &leases);
        let is_interrupted = machine.leases.interruption_count() != leases.interruption_count();
        if is_interrupted {
            // Another daemon, perhaps a copy of this farm, may have taken and printed the same parts: nothing is taken or
            // printed before the folders were compared with the ledger again.
            (machine.agreed_folders, machine.may_claim) = (None, false);
        }
        // They are opened anew; until then nothing is nested for them.
        machine.printers.close_queues(|queue| replaced.contains(queue) || !leases.can_publish(queue));
        let (before, now) = (machine.leases.foreign_claims, leases.foreign_claims);
        machine.leases = *leases;
        if is_interrupted {
            warn!(
                machine = name,
                "Another nestd may have served the folders of {name} meanwhile: they are compared with the ledger."
            );
            folder_comparison::start_folder_comparison(&mut desk);
        }
        adopt::update_foreign_claims_alert(desk.machines, desk.shared.alerts, &name, before, now);
    }
}

/// Acquires the leases on all folders. A folder that another daemon serves makes the start fail; an unavailable
/// folder is retried. Waits until it is clear whether other daemons named in markers are alive.
pub(crate) fn acquire_leases_at_start(machines: &mut MachineStates, alerts: &mut AlertRegistry) -> Result<()> {
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
        update_lease_alerts(alerts, name, &machine.printers, &machine.leases);
    }
    Ok(())
}

/// Renews all leases when they are due, and at once those of a machine whose folders were not checked for too long.
/// Nothing is done with its parts meanwhile.
pub(crate) fn renew_leases(desk: &mut Serving<'_>, is_due: bool) {
    if is_due {
        let (now, scan_secs) = (desk.shared.now(), desk.shared.settings.scan_secs);
        desk.shared.schedule.tasks.record_done(TimedTask::RenewLeases, now, scan_secs);
    }
    for (name, machine) in desk.machines.iter().filter(|(_, s)| is_due || !s.leases.are_fresh()) {
        // A copy of what it renews is older than what it brings back.
        if desk.jobs.is_running::<LeaseRenewalJob>(name) {
            continue;
        }
        let (machine_name, leases) = (name.clone(), Box::new(machine.leases.clone()));
        let queues = machine.printers.open_queues();
        let carried = CarriedLeases { machine: machine_name.clone(), leases, replaced: Vec::new() };
        desk.jobs.start_with(LeaseRenewalJob { machine: machine_name }, carried, move |carried| {
            carried.leases.renew_all();
            let replaced = queues.iter().filter(|(_, queue)| queue.check().is_err());
            carried.replaced = replaced.map(|(_, queue)| queue.address().clone()).collect();
        });
    }
}

/// Gives up what another farm has taken over. The folders count as checked only from there on: what fails is done again by the next
/// renewal.
async fn on_leases_renewed(desk: &mut Batching<'_>, name: &str) -> Result<()> {
    let Some(machine) = desk.machines.get(name) else { return Ok(()) };
    let taken_over = machine.leases.taken_over.clone();
    adopt::give_up_taken_over_claims(desk, name, &taken_over).await?;
    desk.machines.get_mut(name).into_iter().for_each(|machine| machine.leases.confirm_renewal());
    Ok(())
}

/// Releases all leases. Whether another daemon serves the folders does not concern a farm that has stopped.
pub(crate) fn release_leases(machines: &mut MachineStates, alerts: &mut AlertRegistry) {
    for (name, machine) in machines {
        machine.leases.all_leases().into_iter().for_each(FolderLease::release);
        alerts.clear(AlertKind::HeldByOther, name, "");
    }
}

fn update_lease_alerts(alerts: &mut AlertRegistry, name: &str, printers: &MachinePrinters, leases: &FolderLeases) {
    let mut held = Vec::new();
    let of_queue = |printer: &PrinterState| {
        let problem = leases.queue_problem(&printer.address)?.cloned();
        Some((AlertKind::QueueAway, alert_subject(name, &printer.name), printer.down.is_some(), problem))
    };
    let others = LEASE_ALERTS.into_iter().zip(leases.errors.iter().cloned());
    let others = others.map(|(kind, problem)| (kind, String::new(), false, problem));
    let problems: Vec<_> = others.chain(printers.0.iter().filter_map(of_queue)).collect();
    for (kind, of, is_down, problem) in &problems {
        let (kind, is_down) = (*kind, *is_down);
        let about = &format!("lease {of}");
        let about = about.trim_end();
        if let Some(LeaseProblem::HeldByOther(why)) = problem {
            held.push(why.as_str());
        }
        match problem {
            // Of a printer that a person took out of use, everybody knows.
            Some(LeaseProblem::Unavailable(_)) if is_down => alerts.clear(kind, name, about),
            Some(LeaseProblem::Unavailable(why)) => alerts.raise(kind, name, about, why),
            // Within seconds it is clear: nobody needs to act on it.
            Some(LeaseProblem::HolderUnclear(_) | LeaseProblem::HeldByOther(_)) | None => {
                alerts.clear(kind, name, about);
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
