//! What those who watch the farm from outside are shown of each machine: when it was scanned, whether its folders can be used,
//! and whether it is unavailable.

use jiff::SignedDuration;

use super::{
    attention::{Attention, Notice},
    farm::Farm,
};
use crate::ledger::StationSeen;

/// What mends itself within this time makes no machine unavailable.
const LASTS: SignedDuration = SignedDuration::from_secs(10);

/// What keeps a machine from taking parts or from giving builds.
const KINDS: [Attention; 7] = [
    Attention::HotFolderAway,
    Attention::QueueAway,
    Attention::ArchiveAway,
    Attention::ErrorFolderAway,
    Attention::QueueReplaced,
    Attention::FoldersMissing,
    Attention::BuildFailed,
];

impl Farm {
    /// Whether a machine cannot take parts or give builds, if only for a moment.
    pub(super) fn is_unavailable(&self, profile: &str) -> bool {
        self.notices.all().any(|notice| notice.profile == profile && KINDS.contains(&notice.kind))
    }

    /// Every machine as it stands now.
    pub(super) fn stations_seen(&self) -> Vec<StationSeen> {
        let now = self.date();
        let stations = self.stations.iter().map(|(name, station)| {
            let notices: Vec<Notice> =
                self.notices.all().filter(|notice| notice.profile == *name && KINDS.contains(&notice.kind)).collect();
            let is = |kind: Attention| notices.iter().any(|notice| notice.kind == kind);
            let lasts = notices.iter().find(|notice| now.duration_since(notice.since) >= LASTS);
            // After a start nothing is known until all has been looked at once.
            let is_looked_at =
                station.inbox.scanned_at.is_some() && station.queue.opened.is_some() && self.shown.shown_at.is_some();
            StationSeen {
                profile: name.clone(),
                scanned_at: station.inbox.scanned_at,
                is_inbox_there: station.inbox.scanned_at.is_some() && !is(Attention::HotFolderAway),
                is_queue_writable: station.queue.opened.is_some() && !is(Attention::QueueAway),
                trouble: match lasts {
                    Some(notice) => Some(notice.sentence()),
                    None => (is_looked_at && notices.is_empty()).then(String::new),
                },
            }
        });
        stations.collect()
    }
}
