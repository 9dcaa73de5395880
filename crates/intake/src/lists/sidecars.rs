//! Which ticket and which order list belong to which part.

use std::{
    collections::{HashMap, HashSet},
    path::{Path, PathBuf},
};

use super::{
    folder_lists::{FolderLists, entry_list_format, is_part_entry, list_format},
    hidden_sidecar::shown_sidecar,
    misnamed_sidecar::{letters_of_part, loose_part_name},
};
use crate::{
    InboxEntry,
    folder::{
        file_role::{FileRole, file_role, part_of_other_text},
        inbox_entry::{is_hidden, unreadable_reason},
    },
    names::{name::is_part_name, name_match::fold_path},
};

/// The short name that a ticket may use for a part, such as `plain` for `plain.stl`. A name that still ends like a part
/// file is not a short name: `a.stl.toml` waits for `a.stl`, even if `a.stl.3mf` is there.
pub(crate) fn short_name(part: &Path) -> Option<PathBuf> {
    let short = part.with_extension("");
    let is_short_name = |short: &PathBuf| short.file_name().is_some_and(|name| !is_part_name(name));
    part.file_name().filter(|name| is_part_name(name)).and(Some(short)).filter(is_short_name)
}

/// The part that an entry is a ticket of, or may be meant as one: the name that it says, which may be a short one.
fn part_of_sidecar(seen: &InboxEntry) -> Option<PathBuf> {
    let shown = shown_sidecar(&seen.path);
    match file_role(shown.as_deref().unwrap_or(&seen.path)) {
        _ if entry_list_format(seen).is_some() => None,
        FileRole::Ticket { part } => Some(part),
        FileRole::Part => part_of_other_text(&seen.path),
        FileRole::List => None,
    }
}

fn is_ticket(path: &Path) -> bool {
    matches!(file_role(path), FileRole::Ticket { .. })
}

/// A part that waits, because something beside it may say how it is wanted and cannot be read as its ticket.
#[derive(Debug)]
pub(crate) struct BlockingSidecar<'a> {
    pub sidecar: &'a InboxEntry,
    /// Why it cannot be read and what helps: a sentence without its subject, which is the name of the sidecar.
    pub reason: String,
}

/// Tickets and order lists of one scan, by the part that they belong to.
pub(crate) struct SidecarIndex<'a> {
    /// All parts.
    parts: HashSet<&'a Path>,
    /// Parts by folded name (case and Unicode composition ignored): full names, and short names.
    by_folded_name: HashMap<PathBuf, Vec<&'a Path>>,
    by_short_name: HashMap<PathBuf, Vec<&'a Path>>,
    tickets: HashMap<&'a Path, Vec<&'a InboxEntry>>,
    /// Tickets that match several parts.
    ambiguous_tickets: Vec<&'a Path>,
    /// The parts that wait because of a sidecar.
    blocked: HashMap<&'a Path, BlockingSidecar<'a>>,
    /// Tickets that a part takes, and sidecars that a part waits for.
    with_part: HashSet<&'a Path>,
    lists: HashMap<&'a Path, FolderLists<'a>>,
}

impl<'a> SidecarIndex<'a> {
    /// Builds the index. A ticket with a short name is matched to its part only if `is_clear(ticket)`.
    pub fn from_entries(seen: &'a [InboxEntry], is_clear: impl Fn(&Path) -> bool) -> Self {
        let mut beside = Self {
            parts: HashSet::new(),
            by_folded_name: HashMap::new(),
            by_short_name: HashMap::new(),
            tickets: HashMap::new(),
            ambiguous_tickets: Vec::new(),
            blocked: HashMap::new(),
            with_part: HashSet::new(),
            lists: FolderLists::by_folder(seen),
        };
        let sidecars: Vec<(&InboxEntry, PathBuf)> =
            seen.iter().filter_map(|one| Some((one, part_of_sidecar(one)?))).collect();
        for part in seen.iter().filter(|one| is_part_entry(one)) {
            beside.parts.insert(&part.path);
            if !sidecars.is_empty() {
                beside.add_names(&part.path);
            }
        }
        for (sidecar, named) in sidecars {
            beside.add_sidecar(sidecar, &named, &is_clear);
        }
        beside.add_misnamed_sidecars(seen);
        // Beside a ticket, another text is a note, and a hidden ticket is what a program has left.
        let Self { blocked, tickets, .. } = &mut beside;
        let is_rival = |sidecar: &InboxEntry| is_ticket(&sidecar.path) && !is_hidden(sidecar);
        blocked.retain(|part, blocking| is_rival(blocking.sidecar) || !tickets.contains_key(part));
        beside
    }

    fn add_names(&mut self, part: &'a Path) {
        let folded = fold_path(part);
        if let Some(short) = short_name(&folded) {
            self.by_short_name.entry(short).or_default().push(part);
        }
        self.by_folded_name.entry(folded).or_default().push(part);
    }

    fn add_sidecar(&mut self, sidecar: &'a InboxEntry, named: &Path, is_clear: &impl Fn(&Path) -> bool) {
        let meant: Vec<&Path> = self.parts_meant(named).into_iter().filter(|part| *part != sidecar.path).collect();
        let is_ticket = is_ticket(&sidecar.path);
        if is_ticket && meant.len() > 1 {
            self.ambiguous_tickets.push(&sidecar.path);
        }
        let is_full_name = meant[..].iter().any(|part| fold_path(named) == fold_path(part));
        let reason = match &meant[..] {
            [] => return,
            _ if !is_ticket => {
                Some("is not read: a ticket is named like the whole part file with .toml added".to_owned())
            }
            _ if unreadable_reason(sidecar).is_some() => unreadable_reason(sidecar),
            [_] if is_full_name || is_clear(&sidecar.path) => None,
            _ => Some("may be for several parts: name it like the whole part file with .toml added".to_owned()),
        };
        self.with_part.insert(&sidecar.path);
        match reason {
            None => self.tickets.entry(meant[0]).or_default().push(sidecar),
            Some(reason) => meant.into_iter().for_each(|part| {
                self.blocked.entry(part).or_insert(BlockingSidecar { sidecar, reason: reason.clone() });
            }),
        }
    }

    /// Parts wait for what is beside them and may be meant as their ticket under another name.
    fn add_misnamed_sidecars(&mut self, seen: &'a [InboxEntry]) {
        let is_open = |one: &InboxEntry| {
            entry_list_format(one).is_none()
                && !self.with_part.contains(one.path.as_path())
                && file_role(&one.path) != FileRole::List
        };
        let open = seen.iter().filter(|one| is_open(one));
        let misnamed: Vec<(&InboxEntry, String)> =
            open.filter_map(|one| Some((one, loose_part_name(&one.path)?))).collect();
        if misnamed.is_empty() {
            return;
        }
        let mut by_letters: HashMap<(Option<&Path>, String), Vec<&'a Path>> = HashMap::new();
        for part in self.parts.iter().filter(|part| is_part_name(part.file_name().unwrap_or_default())) {
            let keys = letters_of_part(part).into_iter().map(|letters| (part.parent(), letters));
            keys.for_each(|key| by_letters.entry(key).or_default().push(part));
        }
        for (sidecar, letters) in misnamed {
            let meant = by_letters.get(&(sidecar.path.parent(), letters)).into_iter().flatten();
            // Beside a ticket with the right name, it is a note.
            for part in meant.copied().filter(|part| !self.tickets.contains_key(part)).collect::<Vec<_>>() {
                let reason =
                    "may be its ticket, and is not read under this name: a ticket is named like the whole part file \
                              with .toml added"
                        .to_owned();
                self.with_part.insert(&sidecar.path);
                self.blocked.entry(part).or_insert(BlockingSidecar { sidecar, reason });
            }
        }
    }

    /// The parts that a name means: one with exactly this name, else those with it in folded form, else those with it as their
    /// short name.
    fn parts_meant(&self, named: &Path) -> Vec<&'a Path> {
        if let Some(&part) = self.parts.get(named) {
            return vec![part];
        }
        let folded = fold_path(named);
        self.by_folded_name.get(&folded).or_else(|| self.by_short_name.get(&folded)).cloned().unwrap_or_default()
    }

    /// Tickets that match several parts.
    pub fn ambiguous_tickets(&self) -> impl Iterator<Item = &'a Path> {
        self.ambiguous_tickets.iter().copied()
    }

    /// Whether a part takes this ticket or waits for it.
    pub fn has_part(&self, sidecar: &InboxEntry) -> bool {
        self.with_part.contains(sidecar.path.as_path())
    }

    /// What a part waits for.
    pub fn blocking_sidecar(&self, part: &Path) -> Option<&BlockingSidecar<'a>> {
        self.blocked.get(part)
    }

    pub fn tickets_of(&self, part: &Path) -> Vec<&'a InboxEntry> {
        self.tickets.get(part).cloned().unwrap_or_default()
    }

    /// The lists in the folder of an entry.
    pub fn lists_beside(&self, entry: &Path) -> Option<&FolderLists<'a>> {
        self.lists.get(entry.parent()?)
    }
}

/// Tickets, lists and parts that could not be inspected. Parts that they may belong to must wait; otherwise they would
/// be printed in a guessed number of copies.
#[derive(Debug, Default)]
pub(crate) struct UnreadableSidecars {
    /// Folders of order lists.
    folders: HashSet<PathBuf>,
    /// Full or short part names that unreadable tickets refer to.
    names: HashSet<PathBuf>,
    /// Short names of unreadable parts: a readable ticket may belong to one of them.
    short_names: HashSet<PathBuf>,
}

impl UnreadableSidecars {
    /// Creates the set from entries that exist but could not be inspected.
    pub fn from_paths<'a>(paths: impl Iterator<Item = &'a Path>) -> Self {
        let mut unseen = Self::default();
        for path in paths {
            match file_role(path) {
                _ if list_format(path).is_some() => {
                    unseen.folders.insert(path.parent().unwrap_or(Path::new("")).to_owned());
                }
                FileRole::List => _ = unseen.folders.insert(path.parent().unwrap_or(Path::new("")).to_owned()),
                FileRole::Ticket { part } => _ = unseen.names.insert(fold_path(&part)),
                FileRole::Part => unseen.short_names.extend(short_name(&fold_path(path))),
            }
        }
        unseen
    }

    /// Whether one of these entries may belong to a part.
    pub fn may_belong_to(&self, part: &Path) -> bool {
        if self.folders.is_empty() && self.names.is_empty() && self.short_names.is_empty() {
            return false;
        }
        let folded = fold_path(part);
        let short = short_name(&folded);
        let is_in = |names: &HashSet<PathBuf>| short.as_ref().is_some_and(|short| names.contains(short));
        part.parent().is_some_and(|folder| self.folders.contains(folder))
            || self.names.contains(&folded)
            || is_in(&self.names)
            || is_in(&self.short_names)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_waits_as_long_as_its_ticket_or_list_cannot_be_looked_at_and_no_other_part_does() {
        let waits = |unseen: &str, part: &str| {
            UnreadableSidecars::from_paths(std::iter::once(Path::new(unseen))).may_belong_to(Path::new(part))
        };
        for unseen in [
            "in/ring.stl.toml",
            "in/ring.stl.JSON",
            "in/ring.toml",
            "in/order.csv",
            "in/Order.CSV",
            "in/ring.3mf",
            "in/BOM.tsv",
            "in/b.xlsx",
        ] {
            assert!(waits(unseen, "in/ring.stl"), "{unseen}");
        }
        for unseen in
            ["in/plate.stl.toml", "in/kit/ring.stl.toml", "in/kit/order.csv", "in/notes", "in/plate.stl", "in/kit"]
        {
            assert!(!waits(unseen, "in/ring.stl"), "{unseen}");
        }
    }
}
