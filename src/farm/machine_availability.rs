//! What monitoring sees of each machine: when it was scanned, whether its folders can be used, and whether it is
//! unavailable.

use jiff::SignedDuration;

use super::{
    alert::{AlertKind, FarmAlert},
    alert_registry::AlertRegistry,
    farm::Farm,
};
use crate::ledger::ObservedMachine;

/// A problem that ends within this time does not make a machine unavailable.
const UNAVAILABLE_AFTER: SignedDuration = SignedDuration::from_secs(10);

/// Alerts that keep a machine from claiming parts or publishing builds.
const UNAVAILABLE_KINDS: [AlertKind; 7] = [
    AlertKind::HotFolderAway,
    AlertKind::QueueAway,
    AlertKind::ArchiveAway,
    AlertKind::ErrorFolderAway,
    AlertKind::QueueReplaced,
    AlertKind::FoldersMissing,
    AlertKind::BuildFailed,
];

/// Whether a machine cannot claim parts or publish builds at this moment.
pub(super) fn is_unavailable(alerts: &AlertRegistry, profile: &str) -> bool {
    alerts.active_alerts().any(|notice| notice.profile == profile && UNAVAILABLE_KINDS.contains(&notice.kind))
}

/// The current state of every machine.
pub(super) fn observed_machines(farm: &Farm) -> Vec<ObservedMachine> {
    let now = farm.date();
    let stations = farm.machines.iter().map(|(name, station)| {
        let notices: Vec<FarmAlert> = farm
            .alerts
            .active_alerts()
            .filter(|notice| notice.profile == *name && UNAVAILABLE_KINDS.contains(&notice.kind))
            .collect();
        let is = |kind: AlertKind| notices.iter().any(|notice| notice.kind == kind);
        let lasts = notices.iter().find(|notice| now.duration_since(notice.since) >= UNAVAILABLE_AFTER);
        // After a start nothing is known until everything was checked once.
        let is_looked_at =
            station.inbox.scanned_at.is_some() && station.queue.opened.is_some() && farm.display.updated_at.is_some();
        ObservedMachine {
            profile: name.clone(),
            scanned_at: station.inbox.scanned_at,
            is_inbox_there: station.inbox.scanned_at.is_some() && !is(AlertKind::HotFolderAway),
            is_queue_writable: station.queue.opened.is_some() && !is(AlertKind::QueueAway),
            trouble: match lasts {
                Some(notice) => Some(notice.alert_text()),
                None => (is_looked_at && notices.is_empty()).then(String::new),
            },
        }
    });
    stations.collect()
}
