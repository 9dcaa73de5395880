//! What the order lists of a hot folder say about the parts beside them, and which parts wait because a list does not name
//! them: nobody is to get one copy of what a list was to say.

use std::{
    collections::{BTreeMap, HashMap},
    ffi::{OsStr, OsString},
    io::{self, Read},
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};

use super::{
    Kind, Ready, Said, Seen, Ticket,
    beside::{LIST_NAME, Role, role},
    disk, display_name,
    given::read_ticket,
    given_back,
    marks::Marks,
    order_list::{MAX_LIST_BYTES, OrderList},
    same_name::{Meaning, Meant},
};

/// What becomes of a part that stands beside a list and is not in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Unlisted {
    /// It is refused.
    #[default]
    Reject,
    /// It is taken as one copy, with a warning.
    Warn,
}

/// What is to be done with a thing that is ready.
#[derive(Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "one at a time is made and used up at once")]
pub enum Judged {
    /// It may be taken; a part knows what its list says.
    Take(Ready),
    /// It waits, and this is why: part of a sentence.
    Wait(String),
}

/// How long what does not fit together waits, and what then becomes of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ListRules {
    /// So long, seconds.
    pub incomplete_secs: f64,
    /// Then this.
    pub unlisted: Unlisted,
}

/// A list that was read, and what it means to the files of its folder.
#[derive(Debug)]
struct Known {
    /// Inode, change time and size of what was read.
    print: (u64, i128, u64),
    bytes: Vec<u8>,
    list: OrderList,
    /// The files for which `meant` was found out.
    names: Vec<OsString>,
    meant: Meant,
    marks: Marks,
    /// Whether every row is served.
    is_served: bool,
    /// The scan for which all this was found out.
    look: u64,
}

/// The order lists of one hot folder.
#[derive(Debug, Default)]
pub struct Lists {
    known: HashMap<PathBuf, Known>,
    /// The parts in folders that have a list, and when they last changed.
    parts: HashMap<PathBuf, BTreeMap<OsString, i128>>,
    /// Scans taken in.
    looks: u64,
}

impl Lists {
    /// Takes in a scan: what stands beside the lists. Nothing is read before a part asks.
    pub fn observe(&mut self, seen: &[Seen]) {
        let folder_of = |one: &Seen| one.path.parent().unwrap_or(Path::new("")).to_owned();
        self.parts.clear();
        self.looks += 1;
        let files = || seen.iter().filter(|one| one.kind == Kind::File);
        for list in files().filter(|one| role(&one.path) == Role::List) {
            self.parts.entry(folder_of(list)).or_default();
        }
        if self.parts.is_empty() {
            self.known.clear();
            return;
        }
        for part in files().filter(|one| role(&one.path) == Role::Part) {
            let Some(folder) = part.path.parent() else { continue };
            if let (Some(names), Some(name)) = (self.parts.get_mut(folder), part.path.file_name()) {
                names.insert(name.to_owned(), part.ctime_ns);
            }
        }
        self.known.retain(|path, _| path.parent().is_some_and(|folder| self.parts.contains_key(folder)));
    }

    /// Says whether a thing that is ready may be taken as far as order lists go, and with what.
    pub fn judge(
        &mut self,
        inbox: &Path,
        ready: Ready,
        rules: ListRules,
        may_be_part: impl FnOnce(&Path) -> io::Result<bool>,
    ) -> Judged {
        let Ready::Part { part, tickets, list, still_secs, .. } = &ready else { return Judged::Take(ready) };
        let back = given_back::find(inbox, part);
        let said = match list {
            None => back.map(|back| back.said),
            Some(list) => {
                let name = part.path.file_name().unwrap_or_default();
                let asked = back.as_ref().map_or(name, |back| back.name.as_os_str());
                let known = match self.read(inbox, list) {
                    Ok(known) => known,
                    Err(error) => return Judged::Wait(format!("{} cannot be read: {error}", shown(&list.path))),
                };
                match (known.says(asked), &back) {
                    (Ok(said), _) => Some(said),
                    (Err(_), Some(back)) => Some(back.said.clone()),
                    (Err(why), None) => {
                        let is_unclear = known.meant.files.contains_key(asked);
                        let is_free = !(is_unclear || known.holds(list, part.ctime_ns, rules.incomplete_secs))
                            || tickets.iter().any(|ticket| says_copies(&ticket.path))
                            || !may_be_part(&part.path).unwrap_or(true);
                        let what = format!("{} {why}", display_name(name));
                        match (is_free, *still_secs >= rules.incomplete_secs, rules.unlisted) {
                            (true, ..) => None,
                            (_, false, _) => return Judged::Wait(place(part, &what)),
                            (_, true, Unlisted::Reject) => Some(refused(&what, rules.incomplete_secs)),
                            (_, true, Unlisted::Warn) => Some(taken(&what)),
                        }
                    }
                }
            }
        };
        match ready {
            Ready::Part { part, tickets, list, unfinished, still_secs, .. } => {
                Judged::Take(Ready::Part { part, tickets, list, unfinished, still_secs, said })
            }
            other => Judged::Take(other),
        }
    }

    /// A part was claimed with what its list said: its row is served.
    pub fn served(&mut self, ready: &Ready) {
        let Ready::Part { part, list: Some(list), said: Some(Said { file: Some(file), .. }), .. } = ready else {
            return;
        };
        if let (Some(known), Some(name)) = (self.known.get_mut(&list.path), part.path.file_name()) {
            known.marks.add(file, name);
        }
    }

    /// A list as it is, with what it means to the files beside it and to those that were claimed from there.
    fn read(&mut self, inbox: &Path, seen: &Seen) -> io::Result<&Known> {
        let print = (seen.inode, seen.ctime_ns, seen.size);
        let folder = seen.path.parent().unwrap_or(Path::new(""));
        let known = match self.known.remove(&seen.path).filter(|known| known.print == print) {
            Some(known) if known.look == self.looks => known,
            known => {
                let beside = self.parts.get(folder);
                let mut names: Vec<OsString> = beside.into_iter().flat_map(BTreeMap::keys).cloned().collect();
                let known = match known {
                    // A claim that went wrong half-way may be whole, and its mark on the disk alone.
                    Some(known) if !known.marks.are_all() => Known { marks: Marks::load(inbox, seen), ..known },
                    Some(known) => known,
                    None => Known::new(print, read_settled(seen)?, Marks::load(inbox, seen)),
                };
                names.extend(known.marks.files().cloned());
                names.sort();
                names.dedup();
                known.beside(names, self.looks)
            }
        };
        Ok(self.known.entry(seen.path.clone()).or_insert(known))
    }

    /// A list that is ready, for [`end_list`](super::end_list): its content, its marks, and whether parts stand beside it
    /// that it is to be kept for.
    pub(super) fn standing(
        &mut self,
        inbox: &Path,
        list: &Seen,
        incomplete_secs: f64,
    ) -> io::Result<(&OrderList, &Marks, bool)> {
        let folder = list.path.parent().unwrap_or(Path::new(""));
        let parts = self.parts.get(folder).cloned().unwrap_or_default();
        let known = self.read(inbox, list)?;
        let is_needed = parts.iter().any(|(name, &ctime_ns)| {
            known.meant.files.contains_key(name) || known.holds(list, ctime_ns, incomplete_secs)
        });
        Ok((&known.list, &known.marks, is_needed))
    }

    /// Why a list that is ready waits: part of a sentence; `None` = it does not, or only for its parts to settle.
    pub fn missing(&self, list: &Seen) -> Option<String> {
        let known = self.known.get(&list.path)?;
        let name = shown(&list.path);
        let rows = match known.list.rows() {
            Err(why) => return Some(place(list, &format!("{name} is not understood: {why}"))),
            Ok(rows) => rows.iter().enumerate(),
        };
        let missing = rows.filter(|(at, row)| !row.file.is_empty() && !known.meant.named.contains(at));
        let missing: Vec<String> = missing
            .filter(|(_, row)| !known.marks.is_served(&row.file))
            .map(|(_, row)| display_name(OsStr::new(&row.file)))
            .collect();
        let there = if missing.len() == 1 { "is not there" } else { "are not there" };
        (!missing.is_empty()).then(|| place(list, &format!("{name} names {}, which {there}", few(&missing))))
    }
}

impl Known {
    fn new(print: (u64, i128, u64), bytes: Vec<u8>, marks: Marks) -> Self {
        let list = OrderList::parse_beside(&bytes, &[]);
        Self { print, bytes, list, names: Vec::new(), meant: Meant::default(), marks, is_served: false, look: 0 }
    }

    /// What the list means beside these files, if that was not found out before.
    fn beside(mut self, names: Vec<OsString>, look: u64) -> Self {
        if self.names != names {
            let files: Vec<&OsStr> = names.iter().map(OsString::as_os_str).collect();
            self.list = OrderList::parse_beside(&self.bytes, &files);
            self.meant = self.list.meant(files.into_iter());
            self.names = names;
        }
        let is_served = |row: &super::Row| !row.file.is_empty() && self.marks.is_served(&row.file);
        self.is_served = self.list.rows().is_ok_and(|rows| !rows.is_empty() && rows.iter().all(is_served));
        self.look = look;
        self
    }

    /// What the list says about a file; `Err` says why it says nothing.
    fn says(&self, name: &OsStr) -> Result<Said, String> {
        let list = LIST_NAME;
        let rows = self.list.rows().map_err(|why| format!("stands beside {list}, which is not understood: {why}"))?;
        let Some(meaning) = self.meant.files.get(name) else {
            return Err(format!("stands in none of the {} rows of {list}", rows.len()));
        };
        let unclear = matches!(meaning, Meaning::Unclear(..));
        match self.list.row_of(meaning, name) {
            // A claim keeps the row alone: it must say the same there.
            Ok(row) if OrderList::alone(&row.text) != row.ticket => {
                let why = "the list cannot be taken apart into rows; write it anew as UTF-8, with a header and commas";
                Ok(Said { problem: Some(why.to_owned()), ..Said::default() })
            }
            Ok(row) => Ok(Said {
                row: Some(row.text.clone()),
                file: Some(row.file.clone()),
                warnings: self.list.warnings(),
                ..Said::default()
            }),
            Err(why) if unclear => Err(format!("is not clear in {list}: {why}")),
            Err(why) => Ok(Said { problem: Some(why), ..Said::default() }),
        }
    }

    /// Whether a part that the list does not name may have been meant to stand in it: it came while the list was at work. One
    /// that came after all rows were served, or long after the list, is somebody else's.
    fn holds(&self, list: &Seen, part_ctime_ns: i128, incomplete_secs: f64) -> bool {
        let last_ns = self.marks.last_ns().unwrap_or(list.ctime_ns).max(list.ctime_ns);
        match self.is_served {
            true => part_ctime_ns <= last_ns,
            false => part_ctime_ns <= last_ns.saturating_add((incomplete_secs * 1e9) as i128),
        }
    }
}

/// Reads a list, if it still is the one that has settled.
fn read_settled(list: &Seen) -> io::Result<Vec<u8>> {
    let file = disk::open_regular(&list.path)?;
    let mut bytes = Vec::new();
    (&file).take(MAX_LIST_BYTES + 1).read_to_end(&mut bytes)?;
    match disk::is_still(list, &file.metadata()?) {
        true => Ok(bytes),
        false => Err(io::Error::other("it is being written to")),
    }
}

fn says_copies(ticket: &Path) -> bool {
    // One that is broken speaks for its part all the same: the part is refused with it.
    read_ticket(ticket).map_or(true, |ticket: Ticket| ticket.copies.is_some())
}

fn shown(path: &Path) -> String {
    display_name(path.file_name().unwrap_or_default())
}

/// With the order in front, where there is one.
fn place(seen: &Seen, what: &str) -> String {
    if seen.order.is_empty() { what.to_owned() } else { format!("{}/{what}", seen.order) }
}

fn refused(what: &str, incomplete_secs: f64) -> Said {
    let problem = Some(format!("{what}, and that did not change for {incomplete_secs:.0} s"));
    Said { problem, is_unlisted: true, ..Said::default() }
}

fn taken(what: &str) -> Said {
    Said { warnings: vec![format!("It was taken without its order list: {what}.")], ..Said::default() }
}

/// The first of many names.
fn few(names: &[String]) -> String {
    match names {
        names if names.len() <= 5 => names.join(", "),
        names => format!("{}, and {} more", names[..5].join(", "), names.len() - 5),
    }
}
