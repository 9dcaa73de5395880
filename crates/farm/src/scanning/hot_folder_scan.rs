//! The result of one scan of a hot folder, which the event loop takes in.

use std::path::Path;

use intake::{ClaimedPart, ControlFile, InboxEntry, LateTicket, PartSpec, StoredFile, TicketError};
use ledger::{NewPartRow, RefusalCause};

use crate::{AlertKind, alerts::alert_registry::AlertRegistry};

/// A claimed part whose file is in the store.
#[derive(Debug)]
pub struct ClaimedDrop {
    /// The claim.
    pub claim: ClaimedPart,
    /// Its copy in the store.
    pub stored: StoredFile,
    /// What the ticket or list says about it.
    pub part_spec: Result<PartSpec, TicketError>,
    /// The row to record, which is already in the note beside the stored file.
    pub row: NewPartRow,
}

impl ClaimedDrop {
    /// The row to record, and whether it is known what is wanted.
    pub(crate) fn row_to_record(&self) -> (&NewPartRow, bool) {
        (&self.row, self.part_spec.is_ok())
    }
}

/// Why a hot folder cannot be scanned.
#[derive(Debug)]
pub struct UnavailableInbox {
    /// The reason in words.
    pub reason: String,
    /// Its lease is the reason, which the renewal of the leases reports.
    pub is_lease_refused: bool,
}

/// A file that was refused without becoming a part.
#[derive(Debug)]
pub struct RefusedFile {
    /// Its name for people.
    pub name: String,
    /// The kind of refusal.
    pub cause: RefusalCause,
    /// The reason in whole sentences.
    pub reason: String,
}

/// Result of one scan.
#[derive(Debug, Default)]
pub struct HotFolderScan {
    /// Claimed parts whose files are in the store.
    pub drops: Vec<ClaimedDrop>,
    /// Why the hot folder cannot be scanned.
    pub unavailable: Option<UnavailableInbox>,
    /// Seconds until the next useful scan, if something is settling.
    pub next_secs: Option<f64>,
    /// Files that were refused without becoming a part.
    pub refused: Vec<RefusedFile>,
    /// Tickets and rows of lists whose part is not in its folder. The farm looks for a part that was taken before, and
    /// finishes them; those that it leaves are offered again at the next scan.
    pub late_tickets: Vec<LateTicket>,
    /// Archives that hold an order, to be unpacked.
    pub(super) archives: Vec<InboxEntry>,
    /// Control files, the oldest first. The farm obeys and removes them; those that it leaves are offered again at the next
    /// scan.
    pub controls: Vec<ControlFile>,
    /// What waits because it does not match a ticket or an order list, as parts of sentences. What the farm leaves of the late
    /// tickets is added to it.
    pub waiting_reasons: Vec<String>,
    /// Whether more is ready than one scan takes: `held` is incomplete.
    pub is_truncated: bool,
    /// Failures that will be retried.
    pub warnings: Vec<String>,
    /// Folders and files in it that are not looked at, each with the reason.
    pub unseen: Vec<String>,
    /// Refused files that somebody must handle; `None` = not counted this time.
    pub refused_file_count: Option<usize>,
    /// Whether error folder and archive may be written.
    pub(super) may_refuse: bool,
    /// A part may be in a claim that is not listed: claims are listed again, and no order list is completed because all
    /// of its rows seem to be served.
    pub(super) may_have_unknown_claims: bool,
}

impl HotFolderScan {
    /// Reports what was not taken, and what was not looked at.
    pub(crate) fn report_faults(&self, machine: &str, alerts: &mut AlertRegistry) {
        for (kind, faults) in [(AlertKind::TakingFails, &self.warnings), (AlertKind::FolderUnseen, &self.unseen)] {
            let Some(first) = faults.first() else { continue };
            let more = if faults.len() > 1 { format!(", and {} more", faults.len() - 1) } else { String::new() };
            alerts.report_failure(kind, machine, "", &format!("{first}{more}"));
        }
    }
}

/// Name of a file for people.
pub(super) fn file_display_name(path: &Path) -> String {
    path.file_name().map(intake::display_name).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::process::time_source::ClockHands;

    #[test]
    fn a_folder_that_cannot_be_read_is_no_question_of_room() {
        let (clock, time) = ClockHands::make();
        let mut alerts = AlertRegistry::by(time);
        let scan =
            HotFolderScan { unseen: vec!["kit: cannot be read: permission denied".to_owned()], ..Default::default() };
        scan.report_faults("cube", &mut alerts);
        clock.pass(Duration::from_secs(600));
        scan.report_faults("cube", &mut alerts);
        let told: Vec<_> = alerts.active_alerts().collect();
        assert!(told.len() == 1 && told[0].detail.starts_with("kit: cannot be read"), "{told:?}");
        let remedy = told[0].kind.remedy();
        assert!(remedy.contains("read and enter it") && !remedy.contains("room"), "{remedy}");
    }
}
