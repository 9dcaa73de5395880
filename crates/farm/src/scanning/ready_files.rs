//! What becomes of each settled file of a hot folder: a part is claimed, an archive is unpacked, a list is finished, what is refused
//! goes to the error folder, and late tickets and control files are offered to the farm.

use std::collections::HashSet;

use build_file::ReadLimits;
use intake::{
    ClaimedPart, ControlFile, EntryKind, InboxEntry, LateTicket, ListOutcome, OrderListTracker, SettledEntry,
    UnpackOutcome,
};
use ledger::RefusalCause;
use settings::MachineProfile;
use tracing::info;

use super::hot_folder_scan::{HotFolderScan, RefusedFile, file_display_name};
use crate::{alerts::failure::error_chain, leases::folder_lease::FolderLease};

/// A list that cannot be read is reported when it has not changed for this many settle times.
const REPORT_AFTER_SETTLES: f64 = 2.0;

/// Handles the settled files of one scan.
#[derive(Debug)]
pub(crate) struct ReadyFiles<'a> {
    pub hold: &'a FolderLease,
    pub profile: &'a MachineProfile,
    /// Time after which a ticket or row without a file is taken for one that is late, seconds.
    pub late_secs: f64,
    /// Keys of what was offered to the farm for the last time at the scan before. The farm has left it: it is refused now.
    pub earlier_offers: HashSet<String>,
    /// Keys of what is offered for the last time at this scan.
    pub last_offers: &'a mut HashSet<String>,
}

impl ReadyFiles<'_> {
    /// Handles one settled file; a part becomes a claim.
    pub fn process_ready(
        &mut self,
        ready: &SettledEntry,
        lists: &mut OrderListTracker,
        received: &mut HotFolderScan,
    ) -> Option<ClaimedPart> {
        match ready {
            SettledEntry::Part { part, tickets, list: None, unfinished: false, .. }
                if tickets.is_empty() && intake::is_order_archive(self.hold.folder_path(), &part.path) =>
            {
                received.archives.push(part.clone());
            }
            SettledEntry::Part { part, .. } if intake::is_material_library(&part.path) => {
                let archive = &self.profile.folders.archive;
                if received.may_refuse
                    && let Err(error) = intake::archive_material_library(self.hold.folder_path(), part, archive)
                {
                    received.warnings.push(error_chain(&error));
                }
            }
            SettledEntry::Part { .. } => {
                match intake::claim_for_farm(self.hold.folder_path(), ready, self.hold.farm_id()) {
                    Ok(claim) => {
                        lists.mark_row_served(ready);
                        return Some(claim);
                    }
                    // It is still being written to, or was taken away: the next scan decides.
                    Err(intake::ClaimError::Changed(_) | intake::ClaimError::Gone(_)) => {}
                    Err(error) => {
                        received.may_have_unknown_claims = true;
                        received.warnings.push(error_chain(&error));
                    }
                }
            }
            SettledEntry::Control { file, kind } => received.controls.push(ControlFile::from_entry(file, *kind)),
            // It stays where it is until these folders are back; an alert reports them.
            SettledEntry::List { .. } | SettledEntry::Orphan { .. } | SettledEntry::Refuse { .. }
                if !received.may_refuse => {}
            SettledEntry::List { .. } if received.may_have_unknown_claims => {}
            SettledEntry::List { list, quiet_secs } => self.process_list(ready, list, *quiet_secs, lists, received),
            SettledEntry::Orphan { ticket, part_name, expiry_reason } => {
                let is_last_offer = expiry_reason.is_some();
                let late = LateTicket::from_orphan(self.hold.folder_path(), ticket, part_name, is_last_offer)?;
                match expiry_reason {
                    Some(reason) if self.earlier_offers.contains(&late.key) => {
                        refuse_file(self.profile, ticket, RefusalCause::Ticket, reason, received);
                    }
                    _ => self.offer_late_tickets(vec![late], received),
                }
            }
            // It waits, or was made into a refusal, before it comes here.
            SettledEntry::RivalList { .. } | SettledEntry::Blocked { .. } => {}
            SettledEntry::Refuse { seen, reason } => {
                refuse_file(self.profile, seen, refusal_kind(seen), reason, received)
            }
        }
        None
    }

    /// Offers tickets or rows of a list to the farm.
    fn offer_late_tickets(&mut self, late: Vec<LateTicket>, received: &mut HotFolderScan) {
        self.last_offers.extend(late.iter().filter(|late| late.is_last_offer).map(|late| late.key.clone()));
        received.late_tickets.extend(late);
    }

    /// Offers the rows of a list without a file to the farm, and finishes the list if it is done.
    fn process_list(
        &mut self,
        ready: &SettledEntry,
        list: &InboxEntry,
        quiet_secs: f64,
        lists: &mut OrderListTracker,
        received: &mut HotFolderScan,
    ) {
        let (inbox, folders) = (self.hold.folder_path(), &self.profile.folders);
        let incomplete_secs = self.profile.intake.incomplete_secs;
        let is_last_offer = quiet_secs >= incomplete_secs;
        if is_last_offer || quiet_secs >= self.late_secs {
            match LateTicket::from_list(inbox, lists, list, is_last_offer) {
                Ok(late) => {
                    let is_offered = late.iter().all(|late| self.earlier_offers.contains(&late.key));
                    self.offer_late_tickets(late, received);
                    if is_last_offer && !is_offered {
                        return;
                    }
                }
                Err(error) => received.warnings.push(error_chain(&error)),
            }
        }
        match intake::finish_order_list(inbox, lists, ready, incomplete_secs, &folders.archive, &folders.error) {
            Ok(ListOutcome::Refused(reason)) => {
                received.late_tickets.retain(|late| late.entry.path != list.path);
                received.refused.push(RefusedFile {
                    name: file_display_name(&list.path),
                    cause: RefusalCause::Ticket,
                    reason,
                });
            }
            // It may be only the first of its order to be copied.
            Ok(ListOutcome::Awaited) if quiet_secs < REPORT_AFTER_SETTLES * self.profile.intake.settle_secs => {}
            Ok(ListOutcome::Awaited) => received.waiting_reasons.extend(lists.list_fault(list)),
            Ok(ListOutcome::Archived(_)) => {}
            Err(error) => received.warnings.push(error_chain(&error)),
        }
    }
}

fn refuse_file(
    profile: &MachineProfile,
    seen: &InboxEntry,
    cause: RefusalCause,
    reason: &str,
    received: &mut HotFolderScan,
) {
    match intake::refuse_entry(&profile.folders.inbox, seen, &profile.folders.error, reason) {
        Ok(_) => {
            received.refused.push(RefusedFile { name: file_display_name(&seen.path), cause, reason: reason.to_owned() })
        }
        Err(error) => received.warnings.push(error_chain(&error)),
    }
}

/// Unpacks the order archives that a scan has found. The next scan sees what was in them.
pub(crate) fn unpack_archives(profile: &MachineProfile, limits: &ReadLimits, scan: &mut HotFolderScan) {
    for archive in std::mem::take(&mut scan.archives) {
        match intake::unpack_archive(&profile.folders.inbox, &archive, limits) {
            Ok(UnpackOutcome::Unpacked(folder)) => {
                info!(machine = %profile.name, "{} is unpacked: {}.", file_display_name(&archive.path), folder.display());
                scan.next_secs = Some(0.0);
            }
            Ok(UnpackOutcome::Refused(reason)) if scan.may_refuse => {
                refuse_file(profile, &archive, RefusalCause::Format, &reason, scan);
            }
            // What is still being written to, or was taken away, is for the next scan.
            Ok(UnpackOutcome::Refused(_)) | Err(intake::ClaimError::Changed(_) | intake::ClaimError::Gone(_)) => {}
            Err(error) => scan.warnings.push(error_chain(&error)),
        }
    }
}

/// The kind of refusal of a file that is refused without being read: it describes parts, or nestd cannot read it.
fn refusal_kind(seen: &InboxEntry) -> RefusalCause {
    match seen.kind == EntryKind::File && !seen.is_private_link {
        true => RefusalCause::Ticket,
        false => RefusalCause::Unreadable,
    }
}

/// A file that nestd may not read has no hash and so no row: it goes directly into the error folder. Returns whether
/// that worked.
pub(super) fn refuse_unreadable(
    profile: &MachineProfile,
    claim: &ClaimedPart,
    why: &std::io::Error,
    received: &mut HotFolderScan,
) -> bool {
    if !received.may_refuse {
        return false;
    }
    let reason = format!("nestd cannot read this file: {why}. Drop it again with permissions that let nestd read it.");
    let refused = intake::refuse_claim(claim, &profile.folders.error, &reason);
    match &refused {
        Ok(_) => {
            received.refused.push(RefusedFile { name: claim.display_name(), cause: RefusalCause::Unreadable, reason })
        }
        Err(error) => received.warnings.push(error_chain(error)),
    }
    refused.is_ok()
}
