//! Decides which files may be taken: files that have not changed for long enough and are complete. Pure function of the
//! scanned entries and the time.

use std::{
    collections::HashMap,
    io,
    path::{Path, PathBuf},
};

use crate::{
    EntryKind, InboxEntry, SettledEntry, display_name,
    folder::{
        control_file::{ControlName, control_name, misplaced_control_reason},
        file_role::{FileRole, file_role, part_of_other_text},
        inbox_entry::unreadable_reason,
        order_folders::FolderStates,
    },
    lists::{
        folder_lists::{entry_list_format, shown_name, surplus_refusal},
        hidden_sidecar::is_hidden_sidecar,
        sidecars::{BlockingSidecar, SidecarIndex},
    },
};

/// A file with a hole may be an unfinished copy, or may be on a disk that compresses. It must stay unchanged for this
/// many settle times.
const HOLE_SETTLE_FACTOR: f64 = 6.0;
/// Smaller files may be stored inside their inode, with no blocks allocated.
const SMALL_BYTES: u64 = 64 << 10;

/// A ticket or row of a list without a file is said to be late after this many settle times: its file may only be slower.
const LATE_SETTLE_FACTOR: f64 = 3.0;

/// How long files must stay unchanged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SettleRules {
    /// A file must be unchanged for this time, seconds.
    pub settle_secs: f64,
    /// A file whose end is missing is taken, and then refused with a reason, after it was unchanged for this time,
    /// seconds.
    pub unfinished_secs: f64,
    /// A ticket without its part is refused after this time, seconds.
    pub orphan_secs: f64,
}

impl SettleRules {
    /// Seconds after which a ticket or row without a file in its folder is taken for one that is late.
    pub fn late_secs(&self) -> f64 {
        LATE_SETTLE_FACTOR * self.settle_secs
    }
}

/// The attributes that must stay the same for a file to count as settled. Copying programs set old modification times
/// and may allocate the whole size at once, but every write changes the ctime.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct StatFingerprint {
    kind: EntryKind,
    size: u64,
    ctime_ns: i128,
    mtime_ns: i128,
    inode: u64,
    dev: u64,
}

impl StatFingerprint {
    fn from_entry(seen: &InboxEntry) -> Self {
        let InboxEntry { kind, size, ctime_ns, mtime_ns, inode, dev, .. } = *seen;
        Self { kind, size, ctime_ns, mtime_ns, inode, dev }
    }
}

#[derive(Debug, Clone, Copy)]
struct WatchedEntry {
    fingerprint: StatFingerprint,
    /// When the entry was first seen with this fingerprint.
    since_secs: f64,
    /// Number of scans that saw this fingerprint.
    scans: u32,
    /// For a ticket: whether several parts matched it at some time. It is then used for none of them, not even for the
    /// only one that is left.
    is_ambiguous: bool,
}

impl WatchedEntry {
    /// The state of two entries that count as one.
    fn join(self, other: Self) -> Self {
        Self { since_secs: self.since_secs.max(other.since_secs), scans: self.scans.min(other.scans), ..self }
    }
}

/// Remembers for each entry of one hot folder since when it has been unchanged.
#[derive(Debug)]
pub struct SettleTracker {
    rules: SettleRules,
    watched: HashMap<PathBuf, WatchedEntry>,
}

impl SettleTracker {
    /// Creates a tracker that has not seen any entry.
    pub fn new(rules: SettleRules) -> Self {
        Self { rules, watched: HashMap::new() }
    }

    /// Replaces the rules. What was observed so far is kept.
    pub fn set_rules(&mut self, rules: SettleRules) {
        self.rules = rules;
    }

    /// Takes in a scan made at `now_secs` (of any monotonic clock) and returns the entries that may be taken.
    /// `has_end(path, display name)` is called only for files that have settled otherwise; an error counts as "not
    /// complete yet".
    pub fn observe_scan(
        &mut self,
        seen: &[InboxEntry],
        now_secs: f64,
        has_end: impl FnMut(&Path, &str) -> io::Result<bool>,
    ) -> Vec<SettledEntry> {
        self.settled_entries(seen, now_secs, has_end).collect()
    }

    /// Like [`SettleTracker::observe_scan`], but lazy: files after those that the caller consumes are not opened.
    pub fn settled_entries<'a>(
        &'a mut self,
        seen: &'a [InboxEntry],
        now_secs: f64,
        mut has_end: impl FnMut(&Path, &str) -> io::Result<bool> + 'a,
    ) -> impl Iterator<Item = SettledEntry> + 'a {
        self.update_watched(seen, now_secs);
        let beside = SidecarIndex::from_entries(seen, |ticket| !self.is_ambiguous(ticket));
        for ticket in beside.ambiguous_tickets() {
            self.watched.entry(ticket.to_owned()).and_modify(|watched| watched.is_ambiguous = true);
        }
        let this = &*self;
        let orders = this.order_folder_states(seen);
        let is_command = |one: &InboxEntry| one.kind == EntryKind::File && control_name(one).is_some();
        let settled = seen.iter().filter(move |one| this.is_settled(one, now_secs));
        settled.filter_map(move |one| {
            let of_order = orders.get(one.path.parent().unwrap_or(Path::new("")));
            let still_secs = now_secs - of_order.map_or(this.watched[&one.path].since_secs, |order| order.since_secs);
            // A folder is one order. The file copied last, perhaps a list, determines when the whole folder has
            // settled.
            if of_order.is_some_and(|order| !this.stands_still(order, now_secs)) {
                return None;
            }
            match (one.kind, file_role(&one.path)) {
                _ if one.path.file_name().is_some_and(is_hidden_sidecar) => None,
                _ if entry_list_format(one).is_some() => check_list(one, &beside, still_secs),
                _ if beside.has_part(one) => None,
                (EntryKind::File, _) if one.is_private_link => {
                    Some(SettledEntry::Refuse { seen: one.clone(), reason: refusal_of_link(one) })
                }
                (EntryKind::File, _) if is_command(one) => Some(check_control_file(one)),
                // Its part may only be slower, and would be taken without what it says.
                (EntryKind::File, FileRole::Part)
                    if part_of_other_text(&one.path).is_some() && still_secs < this.rules.late_secs() =>
                {
                    None
                }
                (EntryKind::File, FileRole::Part) => this.check_part(one, &beside, now_secs, still_secs, &mut has_end),
                (EntryKind::File, FileRole::Ticket { part }) => this.check_orphan_ticket(one, &part, still_secs),
                (EntryKind::File, FileRole::List) => None,
                (kind, _) => Some(SettledEntry::Refuse { seen: one.clone(), reason: non_file_reason(kind).to_owned() }),
            }
        })
    }

    /// Seconds until another entry may have settled, or `None` if nothing is waiting to settle. Tells when to scan
    /// next.
    pub fn next_scan_secs(&self, now_secs: f64) -> Option<f64> {
        let left = |w: &WatchedEntry| w.since_secs + self.rules.settle_secs - now_secs;
        self.watched.values().filter(|w| w.scans < 2 || left(w) > 0.0).map(|w| left(w).max(0.0)).min_by(f64::total_cmp)
    }

    fn update_watched(&mut self, seen: &[InboxEntry], now_secs: f64) {
        let mut before = std::mem::take(&mut self.watched);
        for one in seen {
            let print = StatFingerprint::from_entry(one);
            let watched = match before.remove(&one.path) {
                Some(known) if known.fingerprint == print => {
                    WatchedEntry { scans: known.scans.saturating_add(1), ..known }
                }
                _ => WatchedEntry { fingerprint: print, since_secs: now_secs, scans: 1, is_ambiguous: false },
            };
            self.watched.insert(one.path.clone(), watched);
        }
    }

    fn is_ambiguous(&self, ticket: &Path) -> bool {
        self.watched.get(ticket).is_some_and(|watched| watched.is_ambiguous)
    }

    fn is_settled(&self, seen: &InboxEntry, now_secs: f64) -> bool {
        self.watched.get(&seen.path).is_some_and(|watched| self.stands_still(watched, now_secs))
    }

    fn stands_still(&self, watched: &WatchedEntry, now_secs: f64) -> bool {
        watched.scans >= 2 && now_secs - watched.since_secs >= self.rules.settle_secs
    }

    /// Treats each order folder, with the folders above and below it, as one entry, and returns since when nothing in it
    /// has changed.
    fn order_folder_states<'a>(&self, seen: &'a [InboxEntry]) -> HashMap<&'a Path, WatchedEntry> {
        let mut states = FolderStates::default();
        for one in seen.iter().filter(|one| !one.order.is_empty()) {
            let (Some(folder), Some(&watched)) = (one.path.parent(), self.watched.get(&one.path)) else { continue };
            states.add(folder, one.order.split('/').count(), watched, WatchedEntry::join);
        }
        states.into_joined(WatchedEntry::join)
    }

    /// A settled part may be taken once its tickets and its list have settled too and the file is complete.
    fn check_part(
        &self,
        part: &InboxEntry,
        beside: &SidecarIndex,
        now_secs: f64,
        order_still_secs: f64,
        has_end: &mut impl FnMut(&Path, &str) -> io::Result<bool>,
    ) -> Option<SettledEntry> {
        let tickets = beside.tickets_of(&part.path);
        let blocking = beside.blocking_sidecar(&part.path);
        let beside = beside.lists_beside(&part.path);
        let list = beside.and_then(|lists| lists.list);
        let rivals = beside.into_iter().flat_map(|lists| lists.rivals.iter().copied());
        let lists: Vec<&InboxEntry> = list.into_iter().chain(rivals).collect();
        let sidecars = || tickets.iter().chain(&lists).copied();
        if !sidecars().all(|sidecar| self.is_settled(sidecar, now_secs)) {
            return None;
        }
        // Without it, the part would be printed in a guessed number of copies.
        if let Some(BlockingSidecar { sidecar, reason }) = blocking {
            let sidecar_still = now_secs - self.watched[&sidecar.path].since_secs;
            return Some(SettledEntry::Blocked {
                part: part.clone(),
                reason: format!("{} {reason}", shown_name(sidecar)),
                still_secs: order_still_secs.min(sidecar_still),
            });
        }
        let still_secs = now_secs - self.watched[&part.path].since_secs;
        let name = display_name(part.path.file_name()?);
        let has_hole = part.allocated < part.size && part.size > SMALL_BYTES;
        if has_hole && still_secs < HOLE_SETTLE_FACTOR * self.rules.settle_secs {
            return None;
        }
        let unfinished = !has_end(&part.path, &name).unwrap_or(false);
        if unfinished && still_secs < self.rules.unfinished_secs {
            return None;
        }
        let list_still = lists.iter().map(|list| now_secs - self.watched[&list.path].since_secs);
        let still_secs = list_still.fold(order_still_secs, f64::min);
        let tickets = tickets.into_iter().cloned().collect();
        Some(SettledEntry::Part {
            part: part.clone(),
            tickets,
            list: list.cloned(),
            lookup: None,
            still_secs,
            unfinished,
        })
    }

    /// Reports a ticket that has no part in its folder, and after some time why it is refused. (A ticket with a part there
    /// belongs to that part, however often a part of that name was taken before.)
    fn check_orphan_ticket(&self, ticket: &InboxEntry, part: &Path, still_secs: f64) -> Option<SettledEntry> {
        let is_ambiguous = self.is_ambiguous(&ticket.path);
        let is_expired = still_secs >= self.rules.orphan_secs;
        if !is_expired && (is_ambiguous || still_secs < self.rules.late_secs()) {
            return None;
        }
        let part_name = part.file_name()?.to_owned();
        let name = display_name(part.file_name()?);
        let what = match is_ambiguous {
            true => format!("several parts were called {name:?}, so it was used for none of them"),
            false => format!("no such part came within {:.0} s", self.rules.orphan_secs),
        };
        let reason = format!(
            "This is a ticket for a part {name:?}, but {what}. \
             Drop the part and the ticket together, the ticket named like the whole part file with .toml or .json added."
        );
        Some(match is_ambiguous {
            true => SettledEntry::Refuse { seen: ticket.clone(), reason },
            false => {
                let expiry_reason = is_expired.then_some(reason);
                SettledEntry::Orphan { ticket: ticket.clone(), part_name, expiry_reason }
            }
        })
    }
}

/// A control file gives its command if it is empty and right in the hot folder.
fn check_control_file(file: &InboxEntry) -> SettledEntry {
    match control_name(file) {
        Some(ControlName::Command(kind)) => SettledEntry::Control { file: file.clone(), kind },
        misplaced => SettledEntry::Refuse { seen: file.clone(), reason: misplaced_control_reason(misplaced, file) },
    }
}

/// An order list is not claimed. It is read as long as its rows are needed. A folder has only one list.
fn check_list(list: &InboxEntry, beside: &SidecarIndex, still_secs: f64) -> Option<SettledEntry> {
    let lists = beside.lists_beside(&list.path)?;
    let (seen, quiet_secs) = (list.clone(), still_secs);
    Some(match lists.list {
        Some(chosen) if chosen == list => SettledEntry::List { list: seen, quiet_secs },
        chosen if lists.surplus.contains(&list) => SettledEntry::Refuse { seen, reason: surplus_refusal(list, chosen) },
        _ => SettledEntry::RivalList { rival: seen, quiet_secs },
    })
}

/// Why a hard link to a private file is refused.
fn refusal_of_link(seen: &InboxEntry) -> String {
    format!("{} {}.", shown_name(seen), unreadable_reason(seen).unwrap_or_default())
}

/// Why an entry that is not a regular file is refused.
fn non_file_reason(kind: EntryKind) -> &'static str {
    match kind {
        EntryKind::File => "This is a file.",
        EntryKind::Symlink => "This is a symbolic link; nestd does not follow links. Drop the file itself.",
        EntryKind::Directory => {
            "This is a folder with the name of a part, a ticket or an order list, or one that lies too deep. A folder is an order: \
             give it another name and drop it right into the hot folder."
        }
        EntryKind::Socket => "This is a socket, not a file. Drop the file of the part.",
        EntryKind::Fifo => "This is a named pipe, not a file. Drop the file of the part.",
        EntryKind::Device => "This is a device, not a file. Drop the file of the part.",
    }
}

#[cfg(test)]
#[path = "tests/settle_tests.rs"]
mod tests;
