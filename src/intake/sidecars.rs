//! Which ticket and which order list belong to which part.

use std::{
    collections::{HashMap, HashSet},
    path::{Path, PathBuf},
};

use super::{
    EntryKind, InboxEntry,
    file_role::{FileRole, file_role},
    folder_lists::{FolderLists, entry_list_format, list_format},
    name::is_part_name,
    name_match::fold_path,
};

/// The short name that a ticket may use for a part, such as `plain` for `plain.stl`. A name that still ends like a part
/// file is not a short name: `a.stl.toml` waits for `a.stl`, even if `a.stl.3mf` is there.
pub(super) fn short_name(part: &Path) -> Option<PathBuf> {
    let short = part.with_extension("");
    let is_short_name = |short: &PathBuf| short.file_name().is_some_and(|name| !is_part_name(name));
    part.file_name().filter(|name| is_part_name(name)).and(Some(short)).filter(is_short_name)
}

/// The part that a ticket belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TicketOwner<'a> {
    Part(&'a Path),
    NoPart,
    /// Its short name matches several parts.
    SeveralParts,
}

/// Tickets and order lists of one scan, by the part that they belong to.
pub(super) struct SidecarIndex<'a> {
    /// All parts.
    pub parts: HashSet<&'a Path>,
    /// Parts by folded name (case and Unicode composition ignored): full names, and short names.
    by_folded_name: HashMap<PathBuf, Vec<&'a Path>>,
    by_short_name: HashMap<PathBuf, Vec<&'a Path>>,
    all_tickets: Vec<&'a InboxEntry>,
    tickets: HashMap<&'a Path, Vec<&'a InboxEntry>>,
    lists: HashMap<&'a Path, FolderLists<'a>>,
}

impl<'a> SidecarIndex<'a> {
    /// Builds the index. A ticket with a short name is matched to its part only if `is_clear(ticket)`.
    pub fn from_entries(seen: &'a [InboxEntry], is_clear: impl Fn(&Path) -> bool) -> Self {
        let mut beside = Self {
            parts: HashSet::new(),
            by_folded_name: HashMap::new(),
            by_short_name: HashMap::new(),
            all_tickets: Vec::new(),
            tickets: HashMap::new(),
            lists: FolderLists::by_folder(seen),
        };
        let files = || seen.iter().filter(|one| one.kind == EntryKind::File && entry_list_format(one).is_none());
        let has_tickets = files().any(|one| matches!(file_role(&one.path), FileRole::Ticket { .. }));
        for one in files() {
            match file_role(&one.path) {
                FileRole::Part => {
                    beside.parts.insert(&one.path);
                    if has_tickets {
                        beside.add_names(&one.path);
                    }
                }
                FileRole::Ticket { .. } => beside.all_tickets.push(one),
                FileRole::List => {}
            }
        }
        for ticket in beside.all_tickets.clone() {
            if let TicketOwner::Part(part) = beside.owner_of_ticket(&ticket.path)
                && (is_clear(&ticket.path) || beside.names_part_in_full(&ticket.path, part))
            {
                beside.tickets.entry(part).or_default().push(ticket);
            }
        }
        beside
    }

    fn add_names(&mut self, part: &'a Path) {
        let folded = fold_path(part);
        if let Some(short) = short_name(&folded) {
            self.by_short_name.entry(short).or_default().push(part);
        }
        self.by_folded_name.entry(folded).or_default().push(part);
    }

    /// Whether a ticket gives the full name of this part, ignoring case and Unicode composition.
    fn names_part_in_full(&self, ticket: &Path, part: &Path) -> bool {
        fold_path(&ticket.with_extension("")) == fold_path(part)
    }

    /// Finds the part of a ticket: first a part with exactly its full name, then the only part with that full name in
    /// folded form, then the only part with that short name.
    fn owner_of_ticket(&self, ticket: &Path) -> TicketOwner<'a> {
        let name = ticket.with_extension("");
        if let Some(&part) = self.parts.get(name.as_path()) {
            return TicketOwner::Part(part);
        }
        let folded = fold_path(&name);
        let found = self.by_folded_name.get(&folded).or_else(|| self.by_short_name.get(&folded));
        match found.map(Vec::as_slice) {
            None | Some([]) => TicketOwner::NoPart,
            Some(&[part]) => TicketOwner::Part(part),
            Some(_) => TicketOwner::SeveralParts,
        }
    }

    /// Tickets that match several parts.
    pub fn ambiguous_tickets(&self) -> impl Iterator<Item = &'a Path> {
        self.all_tickets
            .iter()
            .map(|t| t.path.as_path())
            .filter(|t| self.owner_of_ticket(t) == TicketOwner::SeveralParts)
    }

    /// Whether the ticket was matched to a part.
    pub fn has_part(&self, ticket: &InboxEntry) -> bool {
        let TicketOwner::Part(part) = self.owner_of_ticket(&ticket.path) else { return false };
        self.tickets_of(part).iter().any(|t| t.path == ticket.path)
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
pub(super) struct UnreadableSidecars {
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
