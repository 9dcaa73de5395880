//! What monitoring sees of each machine: when it was scanned, whether its folders can be used, and whether it is
//! unavailable.

use jiff::SignedDuration;
use ledger::ObservedMachine;

use crate::{
    alerts::alert::{AlertKind, FarmAlert},
    core::{desks::Showing, machine_state::MachineState},
    receive::scan_jobs::HotFolderScanJob,
};

/// A problem that ends within this time does not make a machine unavailable.
const UNAVAILABLE_AFTER: SignedDuration = SignedDuration::from_secs(10);

/// Alerts that keep a machine from claiming parts or publishing builds.
const UNAVAILABLE_KINDS: [AlertKind; 8] = [
    AlertKind::HotFolderAway,
    AlertKind::QueueAway,
    AlertKind::ArchiveAway,
    AlertKind::ErrorFolderAway,
    AlertKind::HeldByOther,
    AlertKind::QueueReplaced,
    AlertKind::FoldersMissing,
    AlertKind::BuildFailed,
];

/// Whether an alert keeps its machine from claiming parts or publishing builds. The queue folder of one printer does not, as
/// long as another printer's is open.
fn hinders(alert: &FarmAlert, machine: &MachineState) -> bool {
    let is_spared = alert.kind == AlertKind::QueueAway && machine.printers.has_open_queue();
    UNAVAILABLE_KINDS.contains(&alert.kind) && !is_spared
}

/// The current state of every machine.
pub(crate) fn observed_machines(desk: &Showing<'_>) -> Vec<ObservedMachine> {
    let now = desk.shared.date();
    // The one node of a file needs to tell nobody.
    let tells_profiles = desk.shared.ledger.file().is_none();
    let machines = desk.machines.iter().map(|(name, machine)| {
        let alerts: Vec<FarmAlert> = desk
            .shared
            .alerts
            .active_alerts()
            .filter(|alert| alert.machine == *name && hinders(alert, machine))
            .collect();
        let is = |kind: AlertKind| alerts.iter().any(|alert| alert.kind == kind);
        let lasts = alerts.iter().find(|alert| now.duration_since(alert.since) >= UNAVAILABLE_AFTER);
        // After a start nothing is known until everything was checked once.
        let was_checked = machine.inbox.scanned_at.is_some()
            && machine.printers.has_open_queue()
            && desk.display.updated_at.is_some();
        ObservedMachine {
            machine: name.clone(),
            scanned_at: machine.inbox.scanned_at,
            is_inbox_there: machine.inbox.scanned_at.is_some() && !is(AlertKind::HotFolderAway),
            is_queue_writable: machine.printers.has_open_queue() && !is(AlertKind::QueueAway),
            trouble: match lasts {
                Some(alert) => Some(alert.alert_text()),
                None => (was_checked && alerts.is_empty()).then(String::new),
            },
            profile: if tells_profiles { machine.profile.text.clone() } else { String::new() },
        }
    });
    // A machine that has left the configuration is this node's until the last scan of its hot folder has ended: another one would take
    // apart what that scan puts together.
    let scanned = desk.jobs.running_subjects::<HotFolderScanJob>().filter(|name| !desk.machines.contains_key(*name));
    let leaving = scanned.map(|name| ObservedMachine {
        machine: name.to_owned(),
        scanned_at: None,
        is_inbox_there: true,
        is_queue_writable: false,
        trouble: None,
        profile: String::new(),
    });
    machines.chain(leaving).collect()
}
