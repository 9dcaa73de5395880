//! What stands beside what: which ticket and which order list belong to which part.

use std::{
    collections::{HashMap, HashSet},
    path::{Path, PathBuf},
};

use super::{Kind, Seen, name::is_part_name, same_name::folded_path};

/// The name of an order list.
pub(super) const LIST_NAME: &str = "order.csv";
/// In a claim: what the order list says about its part. A dot-name, which is never taken out of a hot folder.
pub(super) const SAID_NAME: &str = ".said.json";

/// What a file is by its name.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Role {
    Part,
    /// `part` is the ticket's path without its extension: the part, or its short name.
    Ticket {
        part: PathBuf,
    },
    List,
}

/// Tells parts from tickets and order lists; case does not count.
pub(super) fn role(path: &Path) -> Role {
    let Some(name) = path.file_name() else { return Role::Part };
    if name.eq_ignore_ascii_case(LIST_NAME) || name == SAID_NAME {
        return Role::List;
    }
    let is_ticket = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml") || e.eq_ignore_ascii_case("json"));
    match is_ticket {
        true => Role::Ticket { part: path.with_extension("") },
        false => Role::Part,
    }
}

/// The short name by which a ticket may call a part, `plain` for `plain.stl`. A name that still ends like a part file is
/// none: `a.stl.toml` waits for `a.stl`, whatever `a.stl.3mf` stands there.
pub(super) fn short_name(part: &Path) -> Option<PathBuf> {
    let short = part.with_extension("");
    let is_short_name = |short: &PathBuf| short.file_name().is_some_and(|name| !is_part_name(name));
    part.file_name().filter(|name| is_part_name(name)).and(Some(short)).filter(is_short_name)
}

/// Whose a ticket is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Owner<'a> {
    Part(&'a Path),
    Nobody,
    /// Its short name fits several parts.
    Several,
}

/// What stands beside what in one scan.
pub(super) struct Beside<'a> {
    /// All parts.
    pub parts: HashSet<&'a Path>,
    /// By what people do not tell apart: whole names, and short ones.
    by_folded_name: HashMap<PathBuf, Vec<&'a Path>>,
    by_short_name: HashMap<PathBuf, Vec<&'a Path>>,
    all_tickets: Vec<&'a Seen>,
    tickets: HashMap<&'a Path, Vec<&'a Seen>>,
    lists: HashMap<&'a Path, &'a Seen>,
}

impl<'a> Beside<'a> {
    /// Tickets by a short name find their part only if `is_clear(ticket)`.
    pub fn of(seen: &'a [Seen], is_clear: impl Fn(&Path) -> bool) -> Self {
        let mut beside = Self {
            parts: HashSet::new(),
            by_folded_name: HashMap::new(),
            by_short_name: HashMap::new(),
            all_tickets: Vec::new(),
            tickets: HashMap::new(),
            lists: HashMap::new(),
        };
        let files = || seen.iter().filter(|one| one.kind == Kind::File);
        let has_tickets = files().any(|one| matches!(role(&one.path), Role::Ticket { .. }));
        for one in files() {
            match role(&one.path) {
                Role::Part => {
                    beside.parts.insert(&one.path);
                    if has_tickets {
                        beside.add_names(&one.path);
                    }
                }
                Role::Ticket { .. } => beside.all_tickets.push(one),
                Role::List => {
                    beside.lists.entry(one.path.parent().unwrap_or(Path::new(""))).or_insert(one);
                }
            }
        }
        for ticket in beside.all_tickets.clone() {
            if let Owner::Part(part) = beside.owner(&ticket.path)
                && (is_clear(&ticket.path) || beside.is_in_full(&ticket.path, part))
            {
                beside.tickets.entry(part).or_default().push(ticket);
            }
        }
        beside
    }

    fn add_names(&mut self, part: &'a Path) {
        let folded = folded_path(part);
        if let Some(short) = short_name(&folded) {
            self.by_short_name.entry(short).or_default().push(part);
        }
        self.by_folded_name.entry(folded).or_default().push(part);
    }

    /// Whether a ticket names this part to its end, in whatever letters.
    fn is_in_full(&self, ticket: &Path, part: &Path) -> bool {
        folded_path(&ticket.with_extension("")) == folded_path(part)
    }

    /// Whose a ticket is: the part that it names in full, else the one part that it names so in other letters, else the one
    /// that it names in short.
    fn owner(&self, ticket: &Path) -> Owner<'a> {
        let name = ticket.with_extension("");
        if let Some(&part) = self.parts.get(name.as_path()) {
            return Owner::Part(part);
        }
        let folded = folded_path(&name);
        let found = self.by_folded_name.get(&folded).or_else(|| self.by_short_name.get(&folded));
        match found.map(Vec::as_slice) {
            None | Some([]) => Owner::Nobody,
            Some(&[part]) => Owner::Part(part),
            Some(_) => Owner::Several,
        }
    }

    /// Tickets that could be of several parts.
    pub fn unclear(&self) -> impl Iterator<Item = &'a Path> {
        self.all_tickets.iter().map(|t| t.path.as_path()).filter(|t| self.owner(t) == Owner::Several)
    }

    /// Whether a ticket has found its part.
    pub fn is_led(&self, ticket: &Seen) -> bool {
        let Owner::Part(part) = self.owner(&ticket.path) else { return false };
        self.tickets_of(part).iter().any(|t| t.path == ticket.path)
    }

    pub fn tickets_of(&self, part: &Path) -> Vec<&'a Seen> {
        self.tickets.get(part).cloned().unwrap_or_default()
    }

    pub fn list_of(&self, part: &Path) -> Option<&'a Seen> {
        self.lists.get(part.parent()?).copied()
    }
}

/// What could not be looked at: parts to which it may belong must wait, or they would be printed in guessed numbers.
#[derive(Debug, Default)]
pub(super) struct Unseen {
    /// Folders of order lists.
    folders: HashSet<PathBuf>,
    /// Parts that a ticket may call so, in full or in short.
    names: HashSet<PathBuf>,
    /// Short names of parts: a ticket that is seen may be theirs.
    short_names: HashSet<PathBuf>,
}

impl Unseen {
    /// Of things that are there, but could not be looked at.
    pub fn of<'a>(paths: impl Iterator<Item = &'a Path>) -> Self {
        let mut unseen = Self::default();
        for path in paths {
            match role(path) {
                Role::List => _ = unseen.folders.insert(path.parent().unwrap_or(Path::new("")).to_owned()),
                Role::Ticket { part } => _ = unseen.names.insert(folded_path(&part)),
                Role::Part => unseen.short_names.extend(short_name(&folded_path(path))),
            }
        }
        unseen
    }

    /// Whether some of it may belong to a part.
    pub fn may_belong_to(&self, part: &Path) -> bool {
        if self.folders.is_empty() && self.names.is_empty() && self.short_names.is_empty() {
            return false;
        }
        let folded = folded_path(part);
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
        let waits =
            |unseen: &str, part: &str| Unseen::of(std::iter::once(Path::new(unseen))).may_belong_to(Path::new(part));
        for unseen in
            ["in/ring.stl.toml", "in/ring.stl.JSON", "in/ring.toml", "in/order.csv", "in/Order.CSV", "in/ring.3mf"]
        {
            assert!(waits(unseen, "in/ring.stl"), "{unseen}");
        }
        for unseen in
            ["in/plate.stl.toml", "in/kit/ring.stl.toml", "in/kit/order.csv", "in/notes", "in/plate.stl", "in/kit"]
        {
            assert!(!waits(unseen, "in/ring.stl"), "{unseen}");
        }
    }
}
