//! What the order lists of a hot folder say about the parts beside them, and which parts wait because a list does not
//! name them. Otherwise such a part would be printed once, although a list was to state its number of copies.

use std::{
    collections::{BTreeMap, HashMap},
    ffi::OsString,
    io,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};

use super::part_spec::read_ticket_file;
use crate::{
    InboxEntry, ListLookup, SettledEntry, Ticket,
    claim::given_back::{GivenBackPart, find_given_back},
    lists::{
        folder_lists::{FolderLists, is_part_entry, read_seen_list, rival_refusal, shown_name},
        loaded_list::LoadedList,
        order_list::{OrderList, OrderListRow},
        served_rows::{ServedRows, age_secs, path_below_list},
    },
    names::code_page::CodePage,
};

/// Policy for a part in the folder of a list that does not name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UnlistedPolicy {
    /// The part is refused.
    #[default]
    Refuse,
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

/// Lists of one folder that do not count, and hold its parts until a person settles it.
#[derive(Debug)]
pub(super) struct RivalLists {
    pub rivals: Vec<InboxEntry>,
    /// What the parts wait for (part of a sentence).
    reason: String,
}

impl RivalLists {
    /// Whether a part may belong to one of them, because it did not come long after it.
    fn may_cover_part(&self, part_ctime_ns: i128, incomplete_secs: f64) -> bool {
        let wait_ns = (incomplete_secs * 1e9) as i128;
        self.rivals.iter().any(|rival| part_ctime_ns <= rival.ctime_ns.saturating_add(wait_ns))
    }
}

/// How a part stands to a list.
struct ListClaims<'a> {
    /// Whether it lies in a folder below the list.
    is_below: bool,
    is_beside_rival: bool,
    /// Whether its number of copies is known without a list.
    needs_no_list: &'a dyn Fn() -> bool,
}

/// The order lists of one hot folder.
#[derive(Debug, Default)]
pub struct OrderListTracker {
    pub(super) loaded: HashMap<PathBuf, LoadedList>,
    /// The parts in folders that have a list, with their change times.
    parts: HashMap<PathBuf, BTreeMap<OsString, i128>>,
    /// The lists, by their folders.
    pub(super) lists: HashMap<PathBuf, InboxEntry>,
    /// The lists beside them that do not count, by their folders.
    pub(super) rivals: HashMap<PathBuf, RivalLists>,
    /// Number of scans observed.
    scan_count: u64,
    /// Time of the last scan. `None` = the clock of the file system is used.
    now_secs: Option<f64>,
}

/// How far the order of a list has come.
pub(crate) struct ListProgress<'a> {
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
        self.parts.clear();
        self.lists.clear();
        self.scan_count += 1;
        self.rivals.clear();
        for (folder, lists) in FolderLists::by_folder(seen) {
            self.parts.entry(folder.to_owned()).or_default();
            if let Some(list) = lists.list {
                self.lists.insert(folder.to_owned(), list.clone());
            }
            if let Some(reason) = lists.rival_reason() {
                let rivals = lists.rivals.into_iter().cloned().collect();
                self.rivals.insert(folder.to_owned(), RivalLists { rivals, reason });
            }
        }
        if self.parts.is_empty() {
            self.loaded.clear();
            return;
        }
        for part in seen.iter().filter(|one| is_part_entry(one)) {
            let Some(folder) = part.path.parent() else { continue };
            if let (Some(names), Some(name)) = (self.parts.get_mut(folder), part.path.file_name()) {
                names.insert(name.to_owned(), part.ctime_ns);
            } else if let Some(list) = list_of_order(&self.lists, part) {
                let (above, below) = (list.path.parent().unwrap_or(folder), path_below_list(&part.path, &list.path));
                self.parts.entry(above.to_owned()).or_default().insert(below, part.ctime_ns);
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
        may_be_part: impl Fn(&Path) -> io::Result<bool>,
    ) -> TakeDecision {
        let (part, tickets, list, still_secs) = match &ready {
            SettledEntry::Part { part, tickets, list, still_secs, .. } => (part, tickets, list, *still_secs),
            SettledEntry::RivalList { rival, quiet_secs } => return self.check_rival(rival, *quiet_secs, rules),
            SettledEntry::Blocked { part, reason, still_secs } => {
                return check_blocked(part, reason, *still_secs, rules);
            }
            _ => return TakeDecision::Take(ready),
        };
        let back = find_given_back(inbox, part);
        let has_copies = || tickets.iter().any(|ticket| ticket_sets_copies(&ticket.path));
        let of_order = match part.path.parent().is_some_and(|folder| self.rivals.contains_key(folder)) {
            true => None,
            false => list_of_order(&self.lists, part).filter(|_| list.is_none()).cloned(),
        };
        let list = list.as_ref().or(of_order.as_ref());
        let needs_no_list = || has_copies() || !may_be_part(&part.path).unwrap_or(true);
        let name = shown_name(part);
        let is_over = still_secs >= rules.incomplete_secs;
        let rival = self.rival_reason(part, rules).filter(|_| back.is_none() && !needs_no_list());
        let rival = rival.map(|why| format!("{name} stands beside {why}"));
        if let Some(what) = rival.as_ref().filter(|_| !is_over) {
            return TakeDecision::Wait(with_order_prefix(part, what));
        }
        let lookup = match (list, rival) {
            (None, Some(what)) => Some(unlisted_lookup(&what, rules)),
            (None, None) => back.map(|back| back.lookup).or_else(|| self.question_of_other_list(inbox, part)),
            (Some(list), rival) => {
                let claims = ListClaims {
                    is_below: of_order.is_some(),
                    is_beside_rival: rival.is_some(),
                    needs_no_list: &needs_no_list,
                };
                match self.look_up_in_list(inbox, part, list, back, &claims, (is_over, rules)) {
                    Ok(lookup) => lookup,
                    Err(why) => return TakeDecision::Wait(why),
                }
            }
        };
        // A row is served by a part below its list too.
        let used = of_order
            .filter(|_| lookup.as_ref().is_some_and(|said| said.file.is_some() || !said.unused_rows.is_empty()));
        match ready {
            SettledEntry::Part { part, tickets, list, unfinished, still_secs, .. } => {
                let list = list.or(used);
                TakeDecision::Take(SettledEntry::Part { part, tickets, list, unfinished, still_secs, lookup })
            }
            other => TakeDecision::Take(other),
        }
    }

    /// What the list says of a part. `Err` = the part waits, for this reason.
    fn look_up_in_list(
        &mut self,
        inbox: &Path,
        part: &InboxEntry,
        list: &InboxEntry,
        back: Option<GivenBackPart>,
        claims: &ListClaims,
        (is_over, rules): (bool, OrderListRules),
    ) -> Result<Option<ListLookup>, String> {
        let name_then = back.as_ref().map_or_else(|| part.path.clone(), |back| part.path.with_file_name(&back.name));
        let asked = path_below_list(&name_then, &list.path);
        let known =
            self.load_list(inbox, list).map_err(|error| format!("{} cannot be read: {error}", shown_name(list)))?;
        let is_named = known.matches.files.contains_key(&asked);
        match (known.look_up_part(&asked), back) {
            (Ok(said), back) => {
                let rewrites = back.and_then(|back| back.lookup.rewrites);
                Ok(Some(ListLookup { rewrites, ..said }))
            }
            (Err(_), Some(back)) => Ok(Some(back.lookup)),
            // Folders of an order hold other things too, so its list is no reason to refuse them.
            (Err(_), None) if claims.is_below && !is_named => {
                Ok(known.question_below(part).filter(|_| !(claims.needs_no_list)()))
            }
            (Err(why), None) => {
                let is_covered = claims.is_beside_rival
                    || is_named
                    || known.may_cover_part(list, part.ctime_ns, rules.incomplete_secs);
                let what = format!("{} {why}", shown_name(part));
                match is_covered && !(claims.needs_no_list)() {
                    false => Ok(None),
                    true if !is_over => Err(with_order_prefix(part, &what)),
                    true => {
                        let unused_rows = known.rows_for(&asked);
                        Ok(Some(ListLookup { unused_rows, ..unlisted_lookup(&what, rules) }))
                    }
                }
            }
        }
    }

    /// A list beside another one waits like the parts that may belong to it, and is refused after the last of them.
    fn check_rival(&self, rival: &InboxEntry, quiet_secs: f64, rules: OrderListRules) -> TakeDecision {
        let folder = rival.path.parent().unwrap_or(Path::new(""));
        let reason = self.rivals.get(folder).map_or("", |rivals| &rivals.reason);
        let covers = |ctime_ns: &i128| {
            self.rivals.get(folder).is_some_and(|rivals| rivals.may_cover_part(*ctime_ns, rules.incomplete_secs))
        };
        let is_needed = self.parts.get(folder).is_some_and(|parts| parts.values().any(covers));
        match quiet_secs < rules.incomplete_secs || is_needed {
            true => TakeDecision::Wait(with_order_prefix(rival, reason)),
            false => {
                TakeDecision::Take(SettledEntry::Refuse { seen: rival.clone(), reason: rival_refusal(rival, reason) })
            }
        }
    }

    /// What a part waits for because of lists that do not count.
    fn rival_reason(&self, part: &InboxEntry, rules: OrderListRules) -> Option<String> {
        let rivals = self.rivals.get(part.path.parent()?)?;
        rivals.may_cover_part(part.ctime_ns, rules.incomplete_secs).then(|| rivals.reason.clone())
    }

    /// Records that a part was claimed, so its row is served.
    pub fn mark_row_served(&mut self, ready: &SettledEntry) {
        let SettledEntry::Part { part, list: Some(list), lookup: Some(said), .. } = ready else { return };
        let Some(known) = self.loaded.get_mut(&list.path) else { return };
        said.unused_rows.iter().for_each(|row| known.marks.add_unused(row));
        if let Some(file) = &said.file {
            known.marks.add_served(file, &path_below_list(&part.path, &list.path));
            known.served_secs = self.now_secs;
        }
    }

    /// Loads a list in its present state and matches it with the files in its folder and with those already claimed
    /// from there.
    pub(super) fn load_list(&mut self, inbox: &Path, seen: &InboxEntry) -> io::Result<&LoadedList> {
        let print = (seen.inode, seen.ctime_ns, seen.size);
        let folder = seen.path.parent().unwrap_or(Path::new(""));
        let known = match self.loaded.remove(&seen.path).filter(|known| known.fingerprint == print) {
            Some(known) if known.scan_number == self.scan_count => known,
            known => {
                let beside = self.parts.get(folder);
                let mut names: Vec<OsString> = beside.into_iter().flat_map(BTreeMap::keys).cloned().collect();
                let known = match known {
                    // A claim that failed midway may still be complete on disk; then its mark exists only on disk.
                    Some(mut known) if !known.marks.are_complete() => {
                        known.marks = ServedRows::load_marks(inbox, seen);
                        known.served_secs = self.now_secs;
                        known
                    }
                    Some(known) => known,
                    None => LoadedList::new(
                        print,
                        shown_name(seen),
                        read_seen_list(seen)?,
                        ServedRows::load_marks(inbox, seen),
                    ),
                };
                names.extend(known.marks.serving_files().cloned());
                names.sort();
                names.dedup();
                known.match_files(names, self.scan_count)
            }
        };
        Ok(self.loaded.entry(seen.path.clone()).or_insert(known))
    }

    /// Returns how far the order of a list has come, for [`finish_order_list`](crate::finish_order_list).
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

    /// The rows that name no file of the folder and were not served: their parts may have been taken before the list came. With
    /// the code page of the list.
    pub(super) fn rows_without_file(
        &mut self,
        inbox: &Path,
        list: &InboxEntry,
    ) -> io::Result<(CodePage, Vec<OrderListRow>)> {
        let known = self.load_list(inbox, list)?;
        let rows = known.list.rows().unwrap_or_default().iter().enumerate();
        let is_open = |(at, row): &(usize, &OrderListRow)| {
            !row.file.is_empty() && !known.matches.named.contains(at) && !known.marks.is_served(&row.file)
        };
        Ok((known.list.page(), rows.filter(is_open).map(|(_, row)| row.clone()).collect()))
    }

    /// Explains why a settled list cannot be read (part of a sentence). `None` = it can.
    pub fn list_fault(&self, list: &InboxEntry) -> Option<String> {
        let why = self.loaded.get(&list.path)?.list.rows().err()?;
        Some(with_order_prefix(list, &format!("{} is not understood: {why}", shown_name(list))))
    }
}

/// The list of the order that a part below it belongs to: the nearest one in the folders above, but not in the hot folder itself,
/// whose folders are orders of their own.
fn list_of_order<'a>(lists: &'a HashMap<PathBuf, InboxEntry>, part: &InboxEntry) -> Option<&'a InboxEntry> {
    let above = part.path.ancestors().skip(2).take(part.order.split('/').count().saturating_sub(1));
    above.filter_map(|folder| lists.get(folder)).next()
}

/// A part whose ticket cannot be read waits as one beside a list that cannot be read, and is refused in the end.
fn check_blocked(part: &InboxEntry, reason: &str, still_secs: f64, rules: OrderListRules) -> TakeDecision {
    let name = shown_name(part);
    if still_secs < rules.incomplete_secs {
        return TakeDecision::Wait(with_order_prefix(part, &format!("{name} waits, because {reason}")));
    }
    let reason = format!(
        "Beside it stood a file that may say how it is wanted: {reason}. That did not change for {:.0} s, so {name} was not \
         taken without it. Mend that file and drop both again; where it says nothing of the part, drop the part alone.",
        rules.incomplete_secs
    );
    TakeDecision::Take(SettledEntry::Refuse { seen: part.clone(), reason })
}

fn ticket_sets_copies(ticket: &Path) -> bool {
    // A broken ticket counts too: its part is refused with it.
    read_ticket_file(ticket).map_or(true, |ticket: Ticket| ticket.copies.is_some())
}

/// Prefixes a text with the order name, if there is one.
fn with_order_prefix(seen: &InboxEntry, what: &str) -> String {
    if seen.order.is_empty() { what.to_owned() } else { format!("{}/{what}", seen.order) }
}

/// What the policy says about a part that waited long enough for a list that names it.
fn unlisted_lookup(what: &str, rules: OrderListRules) -> ListLookup {
    match rules.unlisted {
        UnlistedPolicy::Refuse => {
            let problem = Some(format!("{what}, and that did not change for {:.0} s", rules.incomplete_secs));
            ListLookup { problem, is_unlisted: true, ..ListLookup::default() }
        }
        UnlistedPolicy::Warn => {
            let warnings = vec![format!("It was taken without its order list: {what}.")];
            ListLookup { warnings, question: Some(what.to_owned()), ..ListLookup::default() }
        }
    }
}
