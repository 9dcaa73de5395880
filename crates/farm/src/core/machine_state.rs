//! The state of an active machine: its hot folder scanner, its printer queue, and its open build. The layout of
//! the open build is updated as parts arrive.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
    time::{Duration, Instant},
};

use jiff::Timestamp;
use ledger::{BuildRow, CommandId, DueArrival, QueuedBuild, UtcTimestamp, WaitingPart, rank_waiting_copies};
use settings::{MachineProfile, Settings};

use super::printer_state::MachinePrinters;
use crate::{
    alerts::alert_registry::AlertRegistry,
    decisions::{
        layout::{BatchLayout, CopyId, LayoutPlacement, placed_from_json},
        left_out::LeftOutNotices,
        printer_outlook::PrinterOutlook,
        trigger::{DueFacts, FireTrigger, TriggerFacts},
    },
    leases::{folder_leases::FolderLeases, lease_holder::LeaseHolder},
    nesting::{layout_search::LayoutSearch, open_night::OpenNight},
    process::{time_source::TimeSource, time_text::written_stamp},
    records::ledger_freshness::FolderIdentities,
    scanning::{hot_folder_scan::RefusedFile, hot_folder_scanner::HotFolderScanner, obeyed_controls::ObeyedControls},
};

/// Wait after a failed search or scan.
const RETRY_AFTER: Duration = Duration::from_secs(15);
/// Arrivals within this time share one search, so that parts dropped together are nested together.
const ARRIVALS_SETTLE: Duration = Duration::from_millis(700);

/// The hot folder of an active machine.
#[derive(Debug)]
pub struct InboxState {
    /// The hot folder scanner; `None` while a job scans the folder with it.
    pub scanner: Option<Box<HotFolderScanner>>,
    /// When the next scan is due.
    pub next_scan_at: Instant,
    /// When this run last scanned it.
    pub scanned_at: Option<UtcTimestamp>,
    /// Number of refused files in the error folder.
    pub refused_file_count: usize,
    /// `.claimed/` must be listed again: claims were adopted, or a claim could not be completed.
    pub relist: bool,
    /// Claim of the newest ordered line that had no part when a scan was last hurried for one.
    pub arriving: Option<String>,
    /// Whether another scan is to follow the running one at once.
    pub is_hurried: bool,
    /// Control files that became commands.
    pub controls: ObeyedControls,
    /// Files that were refused without becoming a part, and of which the ledger has no event yet.
    pub unrecorded_refusals: Vec<RefusedFile>,
}

/// When the open build of a machine is looked at.
#[derive(Debug)]
pub struct BatchPacing {
    /// Whether the search for all waiting copies is done: only a change of the ledger or the passing of time brings new
    /// work.
    pub is_idle: bool,
    /// Whether it waits for room in the queues of its printers.
    pub is_held: bool,
    /// No batch starts before this time.
    pub next_batch_at: Instant,
    /// The passing of time alone may bring work at this time; `None` = it brings none.
    pub wakes_at: Option<Instant>,
}

impl BatchPacing {
    /// Whether the machine waits for a change of the ledger.
    pub fn is_at_rest(&self, now: Instant) -> bool {
        self.is_idle && self.wakes_at.is_none_or(|at| now < at)
    }
}

/// The machines by name.
pub type MachineStates = BTreeMap<String, MachineState>;

/// What the ledger says of the queues of a machine.
#[derive(Debug, Clone, Default)]
pub struct QueuedRows {
    /// Its newest builds that lie in them.
    pub wanted: Vec<QueuedBuild>,
    /// Those of its newest builds of which second files were seen.
    pub copied: Vec<BuildRow>,
}

/// The state of an active machine.
#[derive(Debug)]
pub struct MachineState {
    /// The machine.
    pub profile: Arc<MachineProfile>,
    /// Its hot folder.
    pub inbox: InboxState,
    /// The leases on its folders.
    pub leases: FolderLeases,
    /// Identities of its archive and queues when they last agreed with the ledger; `None` = nothing is printed.
    pub agreed_folders: Option<FolderIdentities>,
    /// Whether files are claimed and read. This starts after its folders were compared with the ledger, and stops while
    /// they contain something that the ledger does not know. Unavailable folders delay only printing.
    pub may_claim: bool,
    /// Its printers.
    pub printers: MachinePrinters,
    /// The build that collects waiting parts.
    pub open: OpenBuildState,
    /// Flush commands that have not been carried out.
    pub pending_flushes: Vec<CommandId>,
    /// When its open build is looked at.
    pub pacing: BatchPacing,
    /// Whether an operator has paused the machine.
    pub paused: bool,
    /// What the ledger says of its queues; `None` = that may have changed since it was read.
    pub queued: Option<QueuedRows>,
    /// Copies that are not in the next build although somebody counts on it.
    pub left_out: LeftOutNotices,
    /// Contents of `STATUS.txt` and `status.json`.
    pub status: (String, serde_json::Value),
}

/// A running search for what has arrived.
#[derive(Debug)]
pub struct ArrivalSearch {
    /// The search. Where it was stopped, its layout may lack copies that would have fitted.
    pub search: LayoutSearch,
    /// The copies to nest.
    pub copies: BTreeSet<CopyId>,
}

/// The layout of the waiting copies that were tried so far.
#[derive(Debug, Default)]
pub struct OpenBuildState {
    /// The best layout of `tried`.
    pub layout: BatchLayout,
    /// The copies of the last completed search.
    pub tried: BTreeSet<CopyId>,
    /// The copies that have stood in the open build since the last completed search.
    pub standing: BTreeSet<CopyId>,
    /// The running search for what has arrived.
    pub search: Option<ArrivalSearch>,
    /// The search that goes on while the build waits, after the one for the last arrival.
    pub night: OpenNight,
    /// Number of searches started.
    pub rounds: u64,
    /// The waiting copies at their last change, and the time of that change.
    waiting_since: Option<(BTreeSet<CopyId>, Instant)>,
    /// Maximum number of copies tried together, after a search with more copies placed nothing; `None` = no limit.
    max_copies: Option<usize>,
    /// After a failed search, no search starts before this time.
    retry_at: Option<Instant>,
}

impl MachineState {
    /// A machine that has scanned nothing yet. `row` is its open build; the search continues from its layout.
    pub fn new(
        profile: Arc<MachineProfile>,
        orphan_secs: f64,
        holder: &LeaseHolder,
        row: &BuildRow,
        time: &TimeSource,
    ) -> Self {
        let placed = row.kept.layout.as_deref().map(placed_from_json).unwrap_or_default();
        let layout = BatchLayout { placed, ..BatchLayout::default() };
        let now = time.instant();
        Self {
            inbox: InboxState {
                scanner: Some(Box::new(HotFolderScanner::new(&profile, orphan_secs, time.clone()))),
                next_scan_at: now,
                scanned_at: None,
                refused_file_count: 0,
                relist: false,
                arriving: None,
                is_hurried: false,
                controls: Default::default(),
                unrecorded_refusals: Vec::new(),
            },
            leases: FolderLeases::new(holder, &profile),
            printers: MachinePrinters::new(&profile, now),
            profile,
            agreed_folders: None,
            may_claim: false,
            open: OpenBuildState { standing: layout.copies(), layout, ..OpenBuildState::default() },
            pending_flushes: Vec::new(),
            pacing: BatchPacing { is_idle: false, is_held: false, next_batch_at: now, wakes_at: None },
            paused: false,
            queued: None,
            left_out: LeftOutNotices::default(),
            status: Default::default(),
        }
    }
}

impl MachineState {
    /// The status files for its hot folder, including alerts; empty until the ledger was queried.
    pub fn status_files(&self, alerts: &AlertRegistry, settings: &Settings) -> (String, String) {
        let (text, json) = &self.status;
        if json.is_null() {
            return Default::default();
        }
        let mut json = json.clone();
        let language = settings.language;
        let (stamp, written_at, renewed_within_secs) =
            language.within(|| written_stamp(settings.scan_secs, &self.profile.time_zone));
        json["attention"] = alerts.status_json_for(&self.profile.name);
        json["running"] = true.into();
        json["written_at"] = written_at.to_string().into();
        json["renewed_within_secs"] = renewed_within_secs.into();
        let attention = language.within(|| alerts.status_text_for(&self.profile.name));
        (attention + text + &stamp, format!("{json:#}\n"))
    }
}

impl MachineState {
    /// The facts for the triggers, from the waiting parts, the copies that are tried together, and the open build. `newest`
    /// is when the newest part of the machine arrived.
    pub fn trigger_facts(
        &self,
        waiting: &[WaitingPart],
        wanted: &BTreeSet<CopyId>,
        newest: Timestamp,
        outlook: &PrinterOutlook,
        (flush, takes_over): (bool, bool),
        knows_the_date: bool,
    ) -> TriggerFacts {
        let (copies, layout) = (waiting.iter().map(|w| w.copies.len()).sum(), &self.open.layout);
        let due = |waits: &WaitingPart| {
            Some(DueArrival { due_at: waits.part.terms.due_at?, arrived_at: waits.part.arrived_at() })
        };
        let dues: Vec<DueArrival> = waiting.iter().filter_map(due).collect();
        let has_more = wanted.len() < copies || !layout.unplaced.is_empty();
        TriggerFacts {
            copies,
            oldest: waiting.iter().map(|w| w.part.waits_since().0).min().unwrap_or_default(),
            due: DueFacts::of_arrivals(&self.profile, outlook, layout.height_mm, &dues, newest),
            height_mm: layout.height_mm,
            density: layout.part_volume_mm3 / self.profile.build_volume().size_mm.element_product(),
            full: self.open.covers_copies(wanted) && !layout.placed.is_empty() && has_more,
            flush,
            takes_over,
            is_date_trusted: knows_the_date,
        }
    }
}

impl OpenBuildState {
    /// The copies that a build takes, and the layout that its final search continues from. A full build takes the
    /// copies that the layout has placed. Any other build takes all copies in `wanted`. Copies without a place after
    /// the final search return to the head of the queue.
    pub fn taken_by(&self, by: FireTrigger, wanted: &BTreeSet<CopyId>) -> (Vec<CopyId>, BatchLayout) {
        let copies: Vec<CopyId> = match by {
            FireTrigger::Full => self.layout.placed.iter().map(|p| p.copy).collect(),
            _ => wanted.iter().copied().collect(),
        };
        let mut layout = BatchLayout { placed: self.best_placements(), ..self.layout.clone() };
        layout.placed.retain(|p| copies.contains(&p.copy));
        (copies, layout)
    }

    /// Whether the layout is a completed search for exactly these copies.
    pub fn covers_copies(&self, wanted: &BTreeSet<CopyId>) -> bool {
        self.search.is_none() && self.tried == *wanted
    }

    /// Whether a search for exactly these copies should start now: they are not covered, the set has not changed for a
    /// moment, and no search runs. Cancels a search for other copies.
    pub fn wants_search(&mut self, wanted: &BTreeSet<CopyId>, now: Instant) -> bool {
        let since = match &self.waiting_since {
            Some((seen, since)) if seen == wanted => *since,
            _ => {
                self.waiting_since = Some((wanted.clone(), now));
                now
            }
        };
        if let Some(running) = &self.search {
            if running.copies != *wanted {
                running.search.stop();
            }
            return false;
        }
        let rested = self.retry_at.is_none_or(|at| now >= at);
        self.tried != *wanted && rested && now.duration_since(since) >= ARRIVALS_SETTLE
    }

    /// What made a search fail is over.
    pub fn retry_at_once(&mut self) {
        self.retry_at = None;
    }

    /// Searches the same copies once more, after a while.
    pub fn retry_tried_later(&mut self, now: Instant) {
        self.tried.clear();
        self.retry_at = Some(now + RETRY_AFTER);
    }

    /// The running search for what has arrived, if it is this one: something else may be wanted of the open build by now.
    pub fn running(&self, search: &LayoutSearch) -> Option<&ArrivalSearch> {
        self.search.as_ref().filter(|running| running.search.is(search))
    }

    /// Records the result of a search. After one that was stopped, the copies count as not tried: which of them are in
    /// was not decided.
    pub fn take_search_result(&mut self, search: &LayoutSearch, layout: Option<BatchLayout>, now: Instant) {
        let Some(running) = self.search.take_if(|running| running.search.is(search)) else { return };
        match layout {
            Some(layout) => {
                self.tried.clear();
                if !running.search.is_stopped() {
                    self.standing = layout.copies();
                    self.tried = running.copies;
                }
                self.layout = layout;
                self.retry_at = None;
            }
            None => self.retry_at = Some(now + RETRY_AFTER),
        }
    }

    /// The placements to continue from: those of the running search if it has found a layout, otherwise those of the
    /// last layout.
    pub fn best_placements(&self) -> Vec<LayoutPlacement> {
        let running = self.search.as_ref().and_then(|running| running.search.best_layout());
        running.map_or_else(|| self.layout.placed.clone(), |layout| layout.placed)
    }

    /// Ends the search that goes on while the build waits, since something else is wanted of it, and takes its best layout.
    pub fn end_night(&mut self) {
        if let Some(found) = self.night.end() {
            self.take_lower_layout(found);
        }
    }

    /// Takes a layout if it places the same copies and is lower. Returns whether it does.
    pub fn take_lower_layout(&mut self, found: BatchLayout) -> bool {
        let is_lower = found.height_mm < self.layout.height_mm && found.copies() == self.layout.copies();
        if is_lower {
            let unplaced = std::mem::take(&mut self.layout.unplaced);
            self.layout = BatchLayout { unplaced, ..found };
        }
        is_lower
    }

    /// The waiting copies in order of precedence, by where they stand now.
    pub fn rank_queue(&self, waiting: Vec<WaitingPart>) -> Vec<WaitingPart> {
        rank_waiting_copies(waiting, |part, copy| self.standing.contains(&(part, copy)))
    }

    /// The parts at the head of the queue that are tried together.
    pub fn truncate_queue(&self, waiting: &[WaitingPart], profile: &MachineProfile) -> Vec<WaitingPart> {
        truncate_to_volume(waiting, profile, self.max_copies.unwrap_or(usize::MAX))
    }

    /// A search of this number of copies placed nothing: half of them are tried next. `true` = it was a single copy,
    /// which does not fit at all.
    pub fn halve_after_empty_search(&mut self, copies: usize) -> bool {
        self.max_copies = (copies > 1).then_some(copies / 2);
        copies == 1
    }

    /// Resets everything: the copies are in a build now, or no part waits any more.
    pub fn reset(&mut self) {
        if let Some(running) = &self.search {
            running.search.stop();
        }
        self.night.stop();
        *self = Self { rounds: self.rounds, ..Self::default() };
    }
}

/// The parts at the head of the queue that are tried together: as many copies as would fill the volume without gaps,
/// because more cannot fit. At most `most` copies, and always at least one.
fn truncate_to_volume(waiting: &[WaitingPart], profile: &MachineProfile, mut most: usize) -> Vec<WaitingPart> {
    let size = profile.build_volume().size_mm;
    let mut room_mm3 = size.x * size.y * size.z;
    let mut head: Vec<WaitingPart> = Vec::new();
    for part in waiting {
        let each = part.part.measures.volume_mm3.unwrap_or(0.0).max(1e-9);
        let fit = ((room_mm3 / each).floor().max(0.0) as usize).min(part.copies.len()).min(most);
        let fit = if head.is_empty() { fit.max(1) } else { fit };
        if fit == 0 {
            break;
        }
        room_mm3 -= fit as f64 * each;
        most -= fit.min(most);
        head.push(WaitingPart { part: part.part.clone(), copies: part.copies[..fit].to_vec() });
        if fit < part.copies.len() {
            break;
        }
    }
    head
}
