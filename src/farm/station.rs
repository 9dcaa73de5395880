//! A machine profile at work: its gate, its printer queue, and its open build, whose layout is kept current as parts arrive.

use std::{
    collections::BTreeSet,
    sync::{Arc, PoisonError},
    time::{Duration, Instant},
};

use nester::SearchBudget;

use super::{
    current::Seen,
    holds::Holds,
    layout::{Copy, Layout, PlacedCopy, placed_from_json},
    nest_order::Best,
    notices::Notices,
    owner::Owner,
    receive::Gate,
    stamp::stamp,
    time_source::TimeSource,
    trigger::{Facts, FiredBy},
};
use crate::{
    ledger::{BuildRow, CommandId, Utc, WaitingPart},
    queue::Queue,
    settings::Profile,
};

/// After a search or a look failed, the next one waits so long.
const RETRY_AFTER: Duration = Duration::from_secs(15);
/// Arrivals within this time share one search, so that a folder of parts dropped at once is nested at once.
const ARRIVALS_SETTLE: Duration = Duration::from_millis(700);

/// The hot folder of a profile at work.
#[derive(Debug)]
pub struct InboxState {
    /// Its memory; away while a job looks through it.
    pub gate: Option<Box<Gate>>,
    /// When to look next.
    pub look_at: Instant,
    /// When it was last looked through in this run.
    pub scanned_at: Option<Utc>,
    /// Refused files that lie in the error folder.
    pub refused_kept: usize,
    /// What lies in `.claimed/` is to be listed anew: claims were adopted, or one could not be ended.
    pub relist: bool,
}

/// The printer queue folder of a profile at work.
#[derive(Debug)]
pub struct QueueFolder {
    /// Once it could be opened.
    pub opened: Option<Queue>,
    /// One that could not be opened is not tried again before this.
    pub open_at: Instant,
}

/// A profile at work.
#[derive(Debug)]
pub struct Station {
    /// The machine.
    pub profile: Arc<Profile>,
    /// Its hot folder.
    pub inbox: InboxState,
    /// That this daemon serves its folders.
    pub holds: Holds,
    /// Its archive and queue as they were when the ledger knew all that they tell; `None` = nothing is printed.
    pub agrees: Option<Seen>,
    /// Whether files are taken and read: not before its folders were held against the ledger, and not while they tell of what
    /// the ledger does not know. Folders that are away only hold up printing.
    pub may_take: bool,
    /// Its printer queue folder.
    pub queue: QueueFolder,
    /// The build that is being gathered.
    pub open: OpenBuild,
    /// Orders to publish now that have not been carried out.
    pub flush: Vec<CommandId>,
    /// Whether all that waits is nested as far as it will be: only news from the ledger or the clock bring work.
    pub is_settled: bool,
    /// Not batched again before this.
    pub batch_at: Instant,
    /// Whether an operator has paused it.
    pub paused: bool,
    /// What `STATUS.txt` and `status.json` say.
    pub status: (String, serde_json::Value),
}

/// A search that runs for the open build.
#[derive(Debug)]
pub struct Search {
    /// Which one; an older one's result is not waited for.
    pub round: u64,
    /// Its clock.
    pub budget: SearchBudget,
    /// Its best layout so far.
    pub best: Best,
    /// The copies that it nests.
    pub copies: BTreeSet<Copy>,
}

/// The layout of what waits, as far as it has been tried.
#[derive(Debug, Default)]
pub struct OpenBuild {
    /// The best layout of `tried`.
    pub layout: Layout,
    /// The copies of the last search that ended.
    pub tried: BTreeSet<Copy>,
    /// The search that runs.
    pub search: Option<Search>,
    /// Searches begun.
    pub rounds: u64,
    /// The waiting copies when they last changed, and when that was.
    seen: Option<(BTreeSet<Copy>, Instant)>,
    /// Copies tried together at most, after a search of more of them placed nothing; `None` = no limit.
    most: Option<usize>,
    /// No search before this time, after one failed.
    retry_at: Option<Instant>,
}

impl Station {
    /// A station that has looked at nothing yet; `row` is its open build, whose layout is gone on from.
    pub fn new(profile: Arc<Profile>, orphan_secs: f64, owner: &Owner, row: &BuildRow, time: &TimeSource) -> Self {
        let placed = row.kept.layout.as_deref().map(placed_from_json).unwrap_or_default();
        let now = time.instant();
        Self {
            inbox: InboxState {
                gate: Some(Box::new(Gate::new(&profile, orphan_secs, time.clone()))),
                look_at: now,
                scanned_at: None,
                refused_kept: 0,
                relist: false,
            },
            holds: Holds::new(owner, &profile),
            profile,
            agrees: None,
            may_take: false,
            queue: QueueFolder { opened: None, open_at: now },
            open: OpenBuild { layout: Layout { placed, ..Layout::default() }, ..OpenBuild::default() },
            flush: Vec::new(),
            is_settled: false,
            batch_at: now,
            paused: false,
            status: Default::default(),
        }
    }
}

impl Station {
    /// What is written into its hot folder, with what a person must see to; empty before the ledger was asked.
    pub fn told(&self, notices: &Notices, scan_secs: f64) -> (String, String) {
        let (text, json) = &self.status;
        if json.is_null() {
            return Default::default();
        }
        let mut json = json.clone();
        let (stamp, written_at, renewed_within_secs) = stamp(scan_secs);
        json["attention"] = notices.json_for(&self.profile.name);
        json["running"] = true.into();
        json["written_at"] = written_at.to_string().into();
        json["renewed_within_secs"] = renewed_within_secs.into();
        (notices.text_for(&self.profile.name) + text + &stamp, format!("{json:#}\n"))
    }
}

impl Station {
    /// What a trigger looks at: the parts that wait, the copies of them that are tried together, and the open build.
    pub fn trigger_facts(
        &self,
        waiting: &[WaitingPart],
        wanted: &BTreeSet<Copy>,
        flush: bool,
        knows_the_date: bool,
    ) -> Facts {
        let (copies, layout) = (waiting.iter().map(|w| w.copies.len()).sum(), &self.open.layout);
        let has_more = wanted.len() < copies || !layout.unplaced.is_empty();
        Facts {
            copies,
            oldest: waiting.iter().map(|w| w.part.times.claimed_at.0).min().unwrap_or_default(),
            due: waiting.iter().filter_map(|w| w.part.terms.due_at.map(|d| d.0)).min(),
            height_mm: layout.height_mm,
            density: layout.part_volume_mm3 / self.profile.build_volume().size_mm.element_product(),
            full: self.open.covers(wanted) && !layout.placed.is_empty() && has_more,
            flush,
            knows_the_date,
        }
    }
}

impl OpenBuild {
    /// The copies that a build takes, and the layout that its final search goes on from. A full build takes what was tried and
    /// stands; any other takes all that waits, and what finds no place after the final search goes back to the head of the line.
    pub fn taken_by(&self, by: FiredBy, wanted: &BTreeSet<Copy>) -> (Vec<Copy>, Layout) {
        let copies: Vec<Copy> = match by {
            FiredBy::Full => self.layout.placed.iter().map(|p| p.copy).collect(),
            _ => wanted.iter().copied().collect(),
        };
        let mut layout = Layout { placed: self.best_placed(), ..self.layout.clone() };
        layout.placed.retain(|p| copies.contains(&p.copy));
        (copies, layout)
    }

    /// Whether the layout is one of exactly these copies, searched to the end of its budget.
    pub fn covers(&self, wanted: &BTreeSet<Copy>) -> bool {
        self.search.is_none() && self.tried == *wanted
    }

    /// Whether a search for exactly these copies should begin now: they are not covered, have not changed for a moment,
    /// and no search runs. A search for other copies is told to end.
    pub fn wants_search(&mut self, wanted: &BTreeSet<Copy>, now: Instant) -> bool {
        let since = match &self.seen {
            Some((seen, since)) if seen == wanted => *since,
            _ => {
                self.seen = Some((wanted.clone(), now));
                now
            }
        };
        if let Some(search) = &self.search {
            if search.copies != *wanted {
                search.budget.cancel();
            }
            return false;
        }
        let rested = self.retry_at.is_none_or(|at| now >= at);
        self.tried != *wanted && rested && now.duration_since(since) >= ARRIVALS_SETTLE
    }

    /// What was tried is searched once more, after a while.
    pub fn forget_tried(&mut self, now: Instant) {
        self.tried.clear();
        self.retry_at = Some(now + RETRY_AFTER);
    }

    /// Takes in what a search found.
    pub fn ended(&mut self, round: u64, layout: Option<Layout>, now: Instant) {
        if self.search.as_ref().is_none_or(|s| s.round != round) {
            return;
        }
        let Some(search) = self.search.take() else { return };
        match layout {
            Some(layout) => {
                self.layout = layout;
                self.tried = search.copies;
                self.retry_at = None;
            }
            None => self.retry_at = Some(now + RETRY_AFTER),
        }
    }

    /// The placements to go on from: those of the running search if it has found something, else the last layout's.
    pub fn best_placed(&self) -> Vec<PlacedCopy> {
        let running = self.search.as_ref().and_then(|search| {
            search.best.lock().unwrap_or_else(PoisonError::into_inner).as_ref().map(|l| l.placed.clone())
        });
        running.unwrap_or_else(|| self.layout.placed.clone())
    }

    /// The head of the line that is tried together.
    pub fn cut(&self, waiting: &[WaitingPart], profile: &Profile) -> Vec<WaitingPart> {
        cut_to_volume(waiting, profile, self.most.unwrap_or(usize::MAX))
    }

    /// A search of `copies` placed nothing: half of them are tried next. `true` = it was one copy alone, which has no
    /// place anywhere.
    pub fn placed_nothing(&mut self, copies: usize) -> bool {
        self.most = (copies > 1).then_some(copies / 2);
        copies == 1
    }

    /// Lets everything go: its copies are in a build now, or nothing waits any more.
    pub fn clear(&mut self) {
        if let Some(search) = &self.search {
            search.budget.cancel();
        }
        *self = Self { rounds: self.rounds, ..Self::default() };
    }
}

/// The parts of the line that are tried together: as many copies as could fill the volume if there were no gaps. What is
/// beyond cannot fit with the others. At most `most` copies, always at least one.
fn cut_to_volume(waiting: &[WaitingPart], profile: &Profile, mut most: usize) -> Vec<WaitingPart> {
    let size = profile.build_volume().size_mm;
    let mut room_mm3 = size.x * size.y * size.z;
    let mut cut: Vec<WaitingPart> = Vec::new();
    for part in waiting {
        let each = part.part.measures.volume_mm3.unwrap_or(0.0).max(1e-9);
        let fit = ((room_mm3 / each).floor().max(0.0) as usize).min(part.copies.len()).min(most);
        let fit = if cut.is_empty() { fit.max(1) } else { fit };
        if fit == 0 {
            break;
        }
        room_mm3 -= fit as f64 * each;
        most -= fit.min(most);
        cut.push(WaitingPart { part: part.part.clone(), copies: part.copies[..fit].to_vec() });
        if fit < part.copies.len() {
            break;
        }
    }
    cut
}
