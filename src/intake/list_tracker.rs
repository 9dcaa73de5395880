//! What the order lists of a hot folder say about the parts beside them, and which parts wait because a list does not
//! name them. Otherwise such a part would be printed once, although a list was to state its number of copies.

use std::{
    collections::{BTreeMap, HashMap},
    ffi::{OsStr, OsString},
    io::{self, Read},
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};

use super::{
    EntryKind, InboxEntry, ListLookup, SettledEntry, Ticket, disk, display_name, given_back,
    name_match::{FileNameMatch, NameMatches, means_file_below},
    order_list::{MAX_LIST_BYTES, OrderList, OrderListRow},
    part_spec::read_ticket_file,
    served_rows::{ServedRows, age_secs},
    sidecars::{FileRole, LIST_NAME, file_role},
};

/// Policy for a part in the folder of a list that does not name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UnlistedPolicy {
    /// The part is refused.
    #[default]
    Reject,
    /// The part is taken as one copy, with a warning.
    Warn,
}

/// Decision about an entry that has settled.
#[derive(Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "one at a time is made and used up at once")]
pub enum TakeDecision {
    /// The entry may be taken. A part carries what its list says.
    Take(SettledEntry),
    /// The entry waits, for this reason (part of a sentence).
    Wait(String),
}

/// How long parts and list rows without a match wait, and what happens then.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrderListRules {
    /// Waiting time, seconds.
    pub incomplete_secs: f64,
    /// What happens to the part afterwards.
    pub unlisted: UnlistedPolicy,
}

/// A loaded list and its matches among the files of its folder.
#[derive(Debug)]
struct LoadedList {
    /// Inode, change time and size of the file that was read.
    fingerprint: (u64, i128, u64),
    bytes: Vec<u8>,
    list: OrderList,
    /// The files that `meant` was computed for.
    names: Vec<OsString>,
    matches: NameMatches,
    marks: ServedRows,
    /// When this process saw a row served, seconds.
    served_secs: Option<f64>,
    /// Whether every row is served.
    is_served: bool,
    /// Number of the scan that this was computed for.
    scan_number: u64,
}

/// The order lists of one hot folder.
#[derive(Debug, Default)]
pub struct OrderListTracker {
    loaded: HashMap<PathBuf, LoadedList>,
    /// The parts in folders that have a list, with their change times.
    parts: HashMap<PathBuf, BTreeMap<OsString, i128>>,
    /// The lists, by their folders.
    lists: HashMap<PathBuf, InboxEntry>,
    /// Number of scans observed.
    scan_count: u64,
    /// Time of the last scan. `None` = the clock of the file system is used.
    now_secs: Option<f64>,
}

/// How far the order of a list has come.
pub(super) struct ListProgress<'a> {
    pub content: &'a OrderList,
    pub marks: &'a ServedRows,
    /// Whether it must stay because of parts in its folder.
    pub is_needed: bool,
    /// Seconds since a row was last served.
    pub idle_secs: f64,
}

impl OrderListTracker {
    /// Sets the time of the next scan, in seconds of any monotonic clock.
    pub fn set_time(&mut self, now_secs: f64) {
        self.now_secs = Some(now_secs);
    }

    /// Takes in a scan and records the parts in folders with a list. Lists are read only when a part needs them.
    pub fn observe_scan(&mut self, seen: &[InboxEntry]) {
        let folder_of = |one: &InboxEntry| one.path.parent().unwrap_or(Path::new("")).to_owned();
        self.parts.clear();
        self.lists.clear();
        self.scan_count += 1;
        let files = || seen.iter().filter(|one| one.kind == EntryKind::File);
        for list in files().filter(|one| file_role(&one.path) == FileRole::List) {
            self.parts.entry(folder_of(list)).or_default();
            self.lists.entry(folder_of(list)).or_insert_with(|| list.clone());
        }
        if self.parts.is_empty() {
            self.loaded.clear();
            return;
        }
        for part in files().filter(|one| file_role(&one.path) == FileRole::Part) {
            let Some(folder) = part.path.parent() else { continue };
            if let (Some(names), Some(name)) = (self.parts.get_mut(folder), part.path.file_name()) {
                names.insert(name.to_owned(), part.ctime_ns);
            }
        }
        self.loaded.retain(|path, _| path.parent().is_some_and(|folder| self.parts.contains_key(folder)));
    }

    /// Decides whether a settled entry may be taken according to the order lists, and adds what its list says.
    pub fn check_against_list(
        &mut self,
        inbox: &Path,
        ready: SettledEntry,
        rules: OrderListRules,
        may_be_part: impl FnOnce(&Path) -> io::Result<bool>,
    ) -> TakeDecision {
        let SettledEntry::Part { part, tickets, list, still_secs, .. } = &ready else {
            return TakeDecision::Take(ready);
        };
        let back = given_back::find_given_back(inbox, part);
        let said = match list {
            None => back.map(|back| back.lookup).or_else(|| self.question_of_list_above(inbox, part)),
            Some(list) => {
                let name = part.path.file_name().unwrap_or_default();
                let asked = back.as_ref().map_or(name, |back| back.name.as_os_str());
                let known = match self.load_list(inbox, list) {
                    Ok(known) => known,
                    Err(error) => {
                        return TakeDecision::Wait(format!(
                            "{} cannot be read: {error}",
                            display_file_name(&list.path)
                        ));
                    }
                };
                match (known.look_up_part(asked), &back) {
                    (Ok(said), _) => Some(said),
                    (Err(_), Some(back)) => Some(back.lookup.clone()),
                    (Err(why), None) => {
                        let is_unclear = known.matches.files.contains_key(asked);
                        let is_free = !(is_unclear || known.may_cover_part(list, part.ctime_ns, rules.incomplete_secs))
                            || tickets.iter().any(|ticket| ticket_sets_copies(&ticket.path))
                            || !may_be_part(&part.path).unwrap_or(true);
                        let what = format!("{} {why}", display_name(name));
                        match (is_free, *still_secs >= rules.incomplete_secs, rules.unlisted) {
                            (true, ..) => None,
                            (_, false, _) => return TakeDecision::Wait(with_order_prefix(part, &what)),
                            (_, true, UnlistedPolicy::Reject) => Some(unlisted_refusal(&what, rules.incomplete_secs)),
                            (_, true, UnlistedPolicy::Warn) => Some(unlisted_warning(&what)),
                        }
                    }
                }
            }
        };
        match ready {
            SettledEntry::Part { part, tickets, list, unfinished, still_secs, .. } => {
                TakeDecision::Take(SettledEntry::Part { part, tickets, list, unfinished, still_secs, lookup: said })
            }
            other => TakeDecision::Take(other),
        }
    }

    /// A list is for the files of its own folder. If one above a part names it all the same, it is asked how many copies
    /// are meant, unless its ticket or name says it.
    fn question_of_list_above(&mut self, inbox: &Path, part: &InboxEntry) -> Option<ListLookup> {
        let above = part.path.ancestors().skip(2).take_while(|folder| folder.starts_with(inbox));
        let lists: Vec<InboxEntry> = above.filter_map(|folder| self.lists.get(folder)).cloned().collect();
        let names_part = |list: &InboxEntry| {
            let folder = list.path.parent()?;
            let relative = part.path.strip_prefix(folder).ok()?.to_str()?.to_owned();
            let may_be_bare = folder != inbox;
            let rows = self.load_list(inbox, list).ok()?.list.rows().ok()?;
            rows.iter().any(|row| means_file_below(&row.file, &relative, may_be_bare)).then_some(())
        };
        lists.iter().find_map(names_part)?;
        let why = format!("{LIST_NAME} in a folder above names it, but a list is for the files of its own folder");
        Some(ListLookup { question: Some(why), ..ListLookup::default() })
    }

    /// Records that a part was claimed, so its row is served.
    pub fn mark_row_served(&mut self, ready: &SettledEntry) {
        let SettledEntry::Part { part, list: Some(list), lookup: Some(ListLookup { file: Some(file), .. }), .. } =
            ready
        else {
            return;
        };
        if let (Some(known), Some(name)) = (self.loaded.get_mut(&list.path), part.path.file_name()) {
            known.marks.add_served(file, name);
            known.served_secs = self.now_secs;
        }
    }

    /// Loads a list in its present state and matches it with the files in its folder and with those already claimed
    /// from there.
    fn load_list(&mut self, inbox: &Path, seen: &InboxEntry) -> io::Result<&LoadedList> {
        let print = (seen.inode, seen.ctime_ns, seen.size);
        let folder = seen.path.parent().unwrap_or(Path::new(""));
        let known = match self.loaded.remove(&seen.path).filter(|known| known.fingerprint == print) {
            Some(known) if known.scan_number == self.scan_count => known,
            known => {
                let beside = self.parts.get(folder);
                let mut names: Vec<OsString> = beside.into_iter().flat_map(BTreeMap::keys).cloned().collect();
                let known = match known {
                    // A claim that failed midway may still be complete on disk; then its mark exists only on disk.
                    Some(known) if !known.marks.are_complete() => {
                        LoadedList { marks: ServedRows::load_marks(inbox, seen), served_secs: self.now_secs, ..known }
                    }
                    Some(known) => known,
                    None => LoadedList::new(print, read_settled_list(seen)?, ServedRows::load_marks(inbox, seen)),
                };
                names.extend(known.marks.serving_files().cloned());
                names.sort();
                names.dedup();
                known.match_files(names, self.scan_count)
            }
        };
        Ok(self.loaded.entry(seen.path.clone()).or_insert(known))
    }

    /// Returns how far the order of a list has come, for [`finish_order_list`](super::finish_order_list).
    pub(super) fn list_progress(
        &mut self,
        inbox: &Path,
        list: &InboxEntry,
        incomplete_secs: f64,
    ) -> io::Result<ListProgress<'_>> {
        let now_secs = self.now_secs;
        let folder = list.path.parent().unwrap_or(Path::new(""));
        let parts = self.parts.get(folder).cloned().unwrap_or_default();
        let known = self.load_list(inbox, list)?;
        let is_needed = parts.iter().any(|(name, &ctime_ns)| {
            known.matches.files.contains_key(name) || known.may_cover_part(list, ctime_ns, incomplete_secs)
        });
        let served_ago =
            now_secs.map_or_else(|| age_secs(&known.marks.dir), |now_secs| known.served_secs.map(|at| now_secs - at));
        let idle_secs = served_ago.unwrap_or(f64::MAX);
        Ok(ListProgress { content: &known.list, marks: &known.marks, is_needed, idle_secs })
    }

    /// The rows that name no file of the folder and were not served: their parts may have been taken before the list came.
    pub(super) fn rows_without_file(&mut self, inbox: &Path, list: &InboxEntry) -> io::Result<Vec<OrderListRow>> {
        let known = self.load_list(inbox, list)?;
        let rows = known.list.rows().unwrap_or_default().iter().enumerate();
        let is_open = |(at, row): &(usize, &OrderListRow)| {
            !row.file.is_empty() && !known.matches.named.contains(at) && !known.marks.is_served(&row.file)
        };
        Ok(rows.filter(is_open).map(|(_, row)| row.clone()).collect())
    }

    /// Explains why a settled list waits (part of a sentence). `None` = it does not wait, or only for its parts to
    /// settle.
    pub fn list_wait_reason(&self, list: &InboxEntry) -> Option<String> {
        let known = self.loaded.get(&list.path)?;
        let name = display_file_name(&list.path);
        let rows = match known.list.rows() {
            Err(why) => return Some(with_order_prefix(list, &format!("{name} is not understood: {why}"))),
            Ok(rows) => rows.iter().enumerate(),
        };
        let missing = rows.filter(|(at, row)| !row.file.is_empty() && !known.matches.named.contains(at));
        let missing: Vec<String> = missing
            .filter(|(_, row)| !known.marks.is_served(&row.file))
            .map(|(_, row)| display_name(OsStr::new(&row.file)))
            .collect();
        let there = if missing.len() == 1 { "is not there" } else { "are not there" };
        (!missing.is_empty())
            .then(|| with_order_prefix(list, &format!("{name} names {}, which {there}", first_names(&missing))))
    }
}

impl LoadedList {
    fn new(print: (u64, i128, u64), bytes: Vec<u8>, marks: ServedRows) -> Self {
        let list = OrderList::parse_for_files(&bytes, &[]);
        Self {
            fingerprint: print,
            bytes,
            list,
            names: Vec::new(),
            matches: NameMatches::default(),
            marks,
            served_secs: None,
            is_served: false,
            scan_number: 0,
        }
    }

    /// Matches the list with these files, unless that was done before.
    fn match_files(mut self, names: Vec<OsString>, look: u64) -> Self {
        if self.names != names {
            let files: Vec<&OsStr> = names.iter().map(OsString::as_os_str).collect();
            self.list = OrderList::parse_for_files(&self.bytes, &files);
            self.matches = self.list.match_files(files.into_iter());
            self.names = names;
        }
        let is_served = |row: &OrderListRow| !row.file.is_empty() && self.marks.is_served(&row.file);
        self.is_served = self.list.rows().is_ok_and(|rows| !rows.is_empty() && rows.iter().all(is_served));
        self.scan_number = look;
        self
    }

    /// Returns what the list says about a file. `Err` says why it says nothing.
    fn look_up_part(&self, name: &OsStr) -> Result<ListLookup, String> {
        let list = LIST_NAME;
        let rows = self.list.rows().map_err(|why| format!("stands beside {list}, which is not understood: {why}"))?;
        let Some(meaning) = self.matches.files.get(name) else {
            return Err(format!("stands in none of the {} rows of {list}", rows.len()));
        };
        if let FileNameMatch::Only(at) = meaning
            && at.iter().any(|&at| self.marks.is_late(&rows[at].file))
        {
            return Err(format!(
                "came after its row in {list} was used for a part of that name that had been taken before"
            ));
        }
        let unclear = matches!(meaning, FileNameMatch::Ambiguous(..));
        match self.list.matched_row(meaning, name) {
            // The claim stores only this row, so the row must parse to the same ticket by itself.
            Ok(row) if OrderList::parse_single_row(&row.text) != row.ticket => {
                let why = "the list cannot be split into rows; save it again as UTF-8, with a header and commas";
                Ok(ListLookup { problem: Some(why.to_owned()), ..ListLookup::default() })
            }
            Ok(row) => Ok(ListLookup {
                row: Some(row.text.clone()),
                file: Some(row.file.clone()),
                warnings: self.list.warnings(),
                ..ListLookup::default()
            }),
            Err(why) if unclear => Err(format!("is not clear in {list}: {why}")),
            Err(why) => Ok(ListLookup { problem: Some(why), ..ListLookup::default() }),
        }
    }

    /// Whether a part that the list does not name may still belong to it, because the part arrived while the list was
    /// being served. A part that arrived after all rows were served, or long after the list, is unrelated to it.
    fn may_cover_part(&self, list: &InboxEntry, part_ctime_ns: i128, incomplete_secs: f64) -> bool {
        let last_ns = self.marks.last_served_ns().unwrap_or(list.ctime_ns).max(list.ctime_ns);
        match self.is_served {
            true => part_ctime_ns <= last_ns,
            false => part_ctime_ns <= last_ns.saturating_add((incomplete_secs * 1e9) as i128),
        }
    }
}

/// Reads a list, provided that it did not change since it settled.
fn read_settled_list(list: &InboxEntry) -> io::Result<Vec<u8>> {
    let file = disk::open_regular_file(&list.path)?;
    let mut bytes = Vec::new();
    (&file).take(MAX_LIST_BYTES + 1).read_to_end(&mut bytes)?;
    match disk::is_unchanged(list, &file.metadata()?) {
        true => Ok(bytes),
        false => Err(io::Error::other("it is being written to")),
    }
}

fn ticket_sets_copies(ticket: &Path) -> bool {
    // A broken ticket counts too: its part is refused with it.
    read_ticket_file(ticket).map_or(true, |ticket: Ticket| ticket.copies.is_some())
}

fn display_file_name(path: &Path) -> String {
    display_name(path.file_name().unwrap_or_default())
}

/// Prefixes a text with the order name, if there is one.
fn with_order_prefix(seen: &InboxEntry, what: &str) -> String {
    if seen.order.is_empty() { what.to_owned() } else { format!("{}/{what}", seen.order) }
}

fn unlisted_refusal(what: &str, incomplete_secs: f64) -> ListLookup {
    let problem = Some(format!("{what}, and that did not change for {incomplete_secs:.0} s"));
    ListLookup { problem, is_unlisted: true, ..ListLookup::default() }
}

fn unlisted_warning(what: &str) -> ListLookup {
    let warnings = vec![format!("It was taken without its order list: {what}.")];
    ListLookup { warnings, question: Some(what.to_owned()), ..ListLookup::default() }
}

/// The first few names of a long list.
fn first_names(names: &[String]) -> String {
    match names {
        names if names.len() <= 5 => names.join(", "),
        names => format!("{}, and {} more", names[..5].join(", "), names.len() - 5),
    }
}
