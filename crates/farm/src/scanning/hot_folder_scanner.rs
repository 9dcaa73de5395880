//! The steps "dropped" and "claimed": settled files in a hot folder are claimed and copied into the store. Only the
//! scan decides; a file-system event just triggers one. The row in the ledger follows in the event loop.

use std::{
    collections::{HashMap, HashSet},
    io,
    path::Path,
    time::{Duration, Instant},
};

use intake::{
    ClaimedPart, ContentStore, EmptiedFolders, InboxEntry, InboxFolder, LateWriting, OrderListRules, OrderListTracker,
    ScanLimits, SettleRules, SettleTracker, StoreError, StoredFile, TakeDecision, TicketError,
};
use ledger::{LedgerError, PartId, PartRow, find_network_file_system};

pub use super::hot_folder_scan::{ClaimedDrop, HotFolderScan, UnavailableInbox};
use super::{
    arriving_lines::ArrivingLines,
    hot_folder_scan::file_display_name,
    ready_files::{ReadyFiles, refuse_unreadable},
};
use settings::MachineProfile;

use crate::{
    alerts::failure::error_chain,
    files::{
        claim_note::{ClaimNote, new_part_row},
        refused_files::RefusedFiles,
    },
    leases::folder_leases::FolderLeases,
    process::time_source::TimeSource,
};

/// Maximum number of parts claimed in one scan: a fixed number, or a share of the files present, whichever is larger.
/// So the first of very many files are read while the rest is claimed, and the scans do not cost more than the files.
const CLAIMS_PER_LOOK: usize = 100;
const SHARE_PER_LOOK: usize = 20;
/// A file that nestd may not read is refused after this time.
const DENIED_GRACE: Duration = Duration::from_secs(5);

/// Interval of counting the refused files.
const RECOUNT_INTERVAL: Duration = Duration::from_secs(2);

/// The refused files that somebody must handle, and when they were last counted.
#[derive(Debug, Default)]
struct RefusedFileCount {
    files: RefusedFiles,
    counted_at: Option<Instant>,
}

/// Scans a hot folder, and remembers what it needs between two scans.
#[derive(Debug)]
pub struct HotFolderScanner {
    inbox: InboxFolder,
    settler: SettleTracker,
    lists: OrderListTracker,
    time: TimeSource,
    started_at: Instant,
    /// Order folders whose files were claimed; they are removed if they stay empty.
    emptied_folders: EmptiedFolders,
    /// Claims that are not in the store yet. `None` = the claims in `.claimed/` must be listed again: at the start,
    /// after the hot folder was unavailable, and after an error there.
    pending: Option<Vec<ClaimedPart>>,
    /// The refused files that somebody must handle.
    refused: RefusedFileCount,
    /// Device and inode of the hot folder at the last scan.
    inbox_identity: Option<(u64, u64)>,
    /// Originals into which more may be written after they were taken.
    late_writing: LateWriting,
    /// Claims with a file that may not be read, and since when.
    unreadable_since: HashMap<String, Instant>,
    /// Keys of the late tickets and lists that were offered for the last time.
    last_offers: HashSet<String>,
    /// Id of the farm that claims.
    farm_id: String,
}

impl HotFolderScanner {
    /// A scanner without memory.
    pub fn new(profile: &MachineProfile, orphan_secs: f64, time: TimeSource) -> Self {
        Self {
            inbox: InboxFolder::new(&profile.folders.inbox, ScanLimits::default()),
            settler: SettleTracker::new(settle_rules(profile, orphan_secs)),
            lists: OrderListTracker::default(),
            started_at: time.instant(),
            time,
            emptied_folders: EmptiedFolders::default(),
            pending: None,
            refused: RefusedFileCount::default(),
            inbox_identity: None,
            late_writing: LateWriting::default(),
            unreadable_since: HashMap::new(),
            last_offers: HashSet::new(),
            farm_id: String::new(),
        }
    }

    /// Whether this is still the scanner of this machine's hot folder.
    pub fn is_for_machine(&self, profile: &MachineProfile) -> bool {
        self.inbox.path() == profile.folders.inbox
    }

    /// The next scan lists the claims in `.claimed/` again.
    pub fn relist_claims(&mut self) {
        self.pending = None;
    }

    /// A claim that could not be recorded is returned by the next scan again.
    pub fn retry_claim(&mut self, claim: ClaimedPart) {
        self.keep_pending(claim);
    }

    /// A late ticket that could not be judged is offered again by the next scan, and not refused.
    pub fn offer_again(&mut self, key: &str) {
        self.last_offers.remove(key);
    }

    /// One scan: claims settled files and ordered lines, and copies them into the store. `find_part` finds the rows of refused parts.
    pub fn scan_and_claim(
        &mut self,
        profile: &MachineProfile,
        leases: &mut FolderLeases,
        store: &ContentStore,
        orphan_secs: f64,
        ordered: &ArrivingLines,
        find_part: impl Fn(PartId) -> Result<Option<PartRow>, LedgerError>,
    ) -> HotFolderScan {
        let mut scan = HotFolderScan::default();
        let lease = &mut leases.inbox;
        if let Err(error) = lease.check_usable() {
            scan.unavailable = Some(UnavailableInbox { reason: error.to_string(), is_lease_refused: true });
            self.pending = None;
            return scan;
        }
        if self.inbox_identity.is_some() && self.inbox_identity != lease.held_identity() {
            // The folder was unavailable and is back, or was replaced on purpose.
            self.inbox = InboxFolder::new(self.inbox.path(), ScanLimits::default());
            self.pending = None;
        }
        self.inbox_identity = lease.held_identity();
        scan.may_refuse = leases.error.check_usable().is_ok() && leases.archive.check_usable().is_ok();
        lease.farm_id().clone_into(&mut self.farm_id);
        self.settler.set_rules(settle_rules(profile, orphan_secs));
        self.give_back_late_writing(profile, &mut scan);
        let mut claims = self.pending_claims(leases.inbox.farm_id(), &mut scan);
        let claims_before = claims.len();
        if leases.may_take_files() && !scan.may_have_unknown_claims {
            claims.extend(ordered.place_lines(self.inbox.path(), &self.farm_id, &mut scan.warnings));
        }
        let has_placed = claims.len() > claims_before;
        match self.inbox.scan() {
            Ok(listing) => {
                scan.unseen.extend(listing.warnings.iter().map(|(path, why)| format!("{}: {why}", path.display())));
                self.claim_ready_files(profile, leases, &listing.entries, &mut claims, &mut scan);
            }
            Err(error) => {
                scan.unavailable = Some(UnavailableInbox { reason: error.to_string(), is_lease_refused: false })
            }
        }
        if claims.is_empty() {
            intake::remove_emptied_claims(self.inbox.path());
        }
        if has_placed {
            // There may be more lines than one scan takes.
            scan.next_secs = Some(0.0);
        }
        // After an error there may be a claim that is not listed: the next scan lists all of them.
        self.pending = (!scan.may_have_unknown_claims).then(Vec::new);
        for claim in claims {
            // The loop has completed this claim while it was being listed.
            if matches!(claim.dir.try_exists(), Ok(false)) {
                continue;
            }
            self.emptied_folders.add_order_folder(&claim);
            self.store_claim(profile, claim, store, &mut scan);
        }
        self.emptied_folders.remove_empty_folders(self.inbox.path(), EmptiedFolders::MIN_AGE);
        if self.refused.counted_at.is_none_or(|at| self.time.passed_since(at) >= RECOUNT_INTERVAL)
            || !scan.refused.is_empty()
        {
            self.refused.counted_at = Some(self.time.instant());
            scan.refused_file_count = scan
                .may_refuse
                .then(|| self.refused.files.count_unresolved(&profile.folders.error, &profile.name, find_part));
        }
        scan
    }

    /// Claims files that have settled and match their order list.
    fn claim_ready_files(
        &mut self,
        profile: &MachineProfile,
        leases: &FolderLeases,
        seen: &[InboxEntry],
        claims: &mut Vec<ClaimedPart>,
        scan: &mut HotFolderScan,
    ) {
        let now_secs = self.time.passed_since(self.started_at).as_secs_f64();
        let most = CLAIMS_PER_LOOK.max(seen.len() / SHARE_PER_LOOK);
        let inbox = self.inbox.path();
        let list_rules =
            OrderListRules { incomplete_secs: profile.intake.incomplete_secs, unlisted: profile.intake.unlisted };
        let has_end = |file: &Path, name: &str| build_file::has_end(&mut intake::open_dropped_file(inbox, file)?, name);
        self.lists.set_time(now_secs);
        self.lists.observe_scan(seen);
        let mut ready_files = ReadyFiles {
            hold: &leases.inbox,
            profile,
            late_secs: settle_rules(profile, 0.0).late_secs(),
            earlier_offers: std::mem::take(&mut self.last_offers),
            last_offers: &mut self.last_offers,
        };
        for ready in self.settler.settled_entries(seen, now_secs, has_end) {
            if claims.len() >= most || !leases.may_take_files() {
                scan.is_truncated = true;
                break;
            }
            let may_be_part = |file: &Path| {
                build_file::may_be_part(&mut intake::open_dropped_file(inbox, file)?, &file_display_name(file))
            };
            match self.lists.check_against_list(inbox, ready, list_rules, may_be_part) {
                TakeDecision::Take(ready) => claims.extend(ready_files.process_ready(&ready, &mut self.lists, scan)),
                // Lists that wait for the same person say the same.
                TakeDecision::Wait(why) if scan.waiting_reasons.last() == Some(&why) => {}
                TakeDecision::Wait(why) => scan.waiting_reasons.push(why),
            }
        }
        scan.controls.sort_by_key(|control| control.entry.ctime_ns);
        scan.next_secs = if scan.is_truncated { Some(0.0) } else { self.settler.next_scan_secs(now_secs) };
    }

    /// Copies a claimed part into the store. After a failure it stays claimed, and the next scan retries it.
    fn store_claim(
        &mut self,
        profile: &MachineProfile,
        claim: ClaimedPart,
        store: &ContentStore,
        scan: &mut HotFolderScan,
    ) {
        match store.store_claimed(&claim) {
            Ok(stored) => match claim.read_part_spec() {
                Err(error @ TicketError::Unreadable { errno, .. })
                    if !self.is_persistently_unreadable(&claim, &io::Error::from_raw_os_error(errno)) =>
                {
                    scan.warnings.push(error.to_string());
                    self.keep_pending(claim);
                }
                part_spec => {
                    self.unreadable_since.remove(&claim.id);
                    let row = new_part_row(profile, &claim, &stored, part_spec.as_ref().ok());
                    let note = ClaimNote::new(&self.farm_id, row, part_spec.as_ref().err());
                    match store.write_note(&stored.hash, &claim.id, &note.to_text()) {
                        Ok(()) => {
                            self.keep_open(&claim, &stored, scan);
                            scan.drops.push(ClaimedDrop { claim, stored, part_spec, row: note.part });
                        }
                        Err(error) => {
                            scan.warnings.push(error_chain(&error));
                            self.keep_pending(claim);
                        }
                    }
                }
            },
            // Somebody still writes to the file: it is given back and settles again.
            Err(StoreError::Changed(_)) => match intake::give_back_claim(&claim) {
                Ok(_) => scan.next_secs = Some(0.0),
                Err(error) => {
                    scan.warnings.push(error_chain(&error));
                    self.keep_pending(claim);
                }
            },
            Err(StoreError::Unreadable { source, .. }) if self.is_persistently_unreadable(&claim, &source) => {
                if !refuse_unreadable(profile, &claim, &source, scan) {
                    self.keep_pending(claim);
                }
            }
            Err(error) => {
                scan.warnings.push(error_chain(&error));
                self.keep_pending(claim);
            }
        }
    }

    /// Keeps the original of a claim open, in case more is written into it. On a network file system an open file could not be
    /// removed with its folder; a writer on another host is told there that its file is gone.
    fn keep_open(&mut self, claim: &ClaimedPart, stored: &StoredFile, scan: &mut HotFolderScan) {
        let now_secs = self.time.passed_since(self.started_at).as_secs_f64();
        let kept = match find_network_file_system(self.inbox.path()) {
            Ok(Some(_)) => Ok(()),
            Ok(None) => self.late_writing.keep_open(claim, stored, &self.farm_id, now_secs),
            Err(error) => Err(error),
        };
        if let Err(error) = kept {
            scan.warnings.push(format!("keeping {} open: {error}", claim.display_name()));
        }
    }

    /// Gives back what was written into originals after they were taken.
    fn give_back_late_writing(&mut self, profile: &MachineProfile, scan: &mut HotFolderScan) {
        let (now_secs, intake) = (self.time.passed_since(self.started_at).as_secs_f64(), &profile.intake);
        if let Err(error) = self.late_writing.give_back_changed(now_secs, intake.settle_secs, intake.unfinished_secs) {
            scan.warnings.push(format!("taking again what was written later: {error}"));
        }
    }

    fn keep_pending(&mut self, claim: ClaimedPart) {
        if let Some(pending) = &mut self.pending {
            pending.push(claim);
        }
    }

    /// Whether a file cannot be read for longer than a moment: shares sometimes say "permission denied" in passing.
    fn is_persistently_unreadable(&mut self, claim: &ClaimedPart, why: &io::Error) -> bool {
        if why.kind() != io::ErrorKind::PermissionDenied {
            return why.raw_os_error().is_none_or(|code| code == rustix::io::Errno::LOOP.raw_os_error());
        }
        let since = *self.unreadable_since.entry(claim.id.clone()).or_insert_with(|| self.time.instant());
        self.time.passed_since(since) >= DENIED_GRACE
    }

    /// Claims that wait for the store; at the first scan, those that an earlier run left.
    fn pending_claims(&mut self, farm: &str, scan: &mut HotFolderScan) -> Vec<ClaimedPart> {
        if let Some(pending) = self.pending.take() {
            return pending;
        }
        match intake::recover_claims(self.inbox.path(), farm) {
            Ok((claims, warnings)) => {
                scan.may_have_unknown_claims = !warnings.is_empty();
                scan.warnings.extend(warnings);
                claims
            }
            Err(error) => {
                scan.may_have_unknown_claims = true;
                scan.warnings.push(error_chain(&error));
                Vec::new()
            }
        }
    }
}

fn settle_rules(profile: &MachineProfile, orphan_secs: f64) -> SettleRules {
    SettleRules {
        settle_secs: profile.intake.settle_secs,
        unfinished_secs: profile.intake.unfinished_secs,
        orphan_secs,
    }
}
