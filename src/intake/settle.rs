//! Decides what may be taken: what stood still long enough and is there to its end. Pure: seen + now -> ready.

use std::{
    collections::HashMap,
    io,
    path::{Path, PathBuf},
};

use super::{
    Kind, Ready, Seen,
    beside::{Beside, Role, role},
    display_name,
};

/// A file with a hole may be a copy under way, or on a disk that compresses: it waits so many settle times.
const HOLE_SETTLES: f64 = 6.0;
/// Smaller files may be kept inside their inode, with nothing allocated.
const SMALL_BYTES: u64 = 64 << 10;

/// How long things must stand still.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SettleRules {
    /// A file must be unchanged so long, seconds.
    pub settle_secs: f64,
    /// A file whose end is missing is taken (to be refused with a reason) after it stood unchanged so long, seconds.
    pub unfinished_secs: f64,
    /// A ticket without its part is refused after so long, seconds.
    pub orphan_secs: f64,
}

impl Default for SettleRules {
    fn default() -> Self {
        Self { settle_secs: 5.0, unfinished_secs: 600.0, orphan_secs: 3600.0 }
    }
}

/// What must stay the same for a file to be settled. Copiers set old mtimes and may allocate the whole size at once, but
/// every write changes the ctime.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Print {
    kind: Kind,
    size: u64,
    ctime_ns: i128,
    mtime_ns: i128,
    inode: u64,
    dev: u64,
}

impl Print {
    fn of(seen: &Seen) -> Self {
        let Seen { kind, size, ctime_ns, mtime_ns, inode, dev, .. } = *seen;
        Self { kind, size, ctime_ns, mtime_ns, inode, dev }
    }
}

#[derive(Debug, Clone, Copy)]
struct Watched {
    print: Print,
    /// When it was first seen like this.
    since_secs: f64,
    /// Scans that saw it like this.
    scans: u32,
    /// For a ticket: whether it could have been of several parts. Then it is of none, not of the one that is left.
    is_unclear: bool,
}

/// Remembers since when each thing in one hot folder has been unchanged.
#[derive(Debug)]
pub struct Settler {
    rules: SettleRules,
    watched: HashMap<PathBuf, Watched>,
}

impl Settler {
    /// Knows nothing yet.
    pub fn new(rules: SettleRules) -> Self {
        Self { rules, watched: HashMap::new() }
    }

    /// Other rules from now on; what is known is kept.
    pub fn set_rules(&mut self, rules: SettleRules) {
        self.rules = rules;
    }

    /// Takes in a scan made at `now_secs` (of any clock that never runs backwards) and says what may be taken.
    /// `has_end(path, display name)` is asked only for files that otherwise have settled; an error counts as "not yet".
    pub fn observe(
        &mut self,
        seen: &[Seen],
        now_secs: f64,
        has_end: impl FnMut(&Path, &str) -> io::Result<bool>,
    ) -> Vec<Ready> {
        self.ready(seen, now_secs, has_end).collect()
    }

    /// As [`Settler::observe`], one after the other: files behind those that are asked for are not opened.
    pub fn ready<'a>(
        &'a mut self,
        seen: &'a [Seen],
        now_secs: f64,
        mut has_end: impl FnMut(&Path, &str) -> io::Result<bool> + 'a,
    ) -> impl Iterator<Item = Ready> + 'a {
        self.remember(seen, now_secs);
        let beside = Beside::of(seen, |ticket| !self.is_unclear(ticket));
        for ticket in beside.unclear() {
            self.watched.entry(ticket.to_owned()).and_modify(|watched| watched.is_unclear = true);
        }
        let this = &*self;
        let orders = this.orders_since(seen);
        let settled = seen.iter().filter(move |one| this.is_settled(one, now_secs));
        settled.filter_map(move |one| {
            let of_order = orders.get(one.path.parent().unwrap_or(Path::new("")));
            let still_secs = now_secs - of_order.map_or(this.watched[&one.path].since_secs, |order| order.since_secs);
            // A folder is an order: what is copied last, a list perhaps, counts for all of it.
            if of_order.is_some_and(|order| !this.stands_still(order, now_secs)) {
                return None;
            }
            match (one.kind, role(&one.path)) {
                (Kind::File, _) if one.is_secret => Some(Ready::Refuse { seen: one.clone(), reason: of_secret(one) }),
                (Kind::File, Role::Part) => this.part(one, &beside, now_secs, still_secs, &mut has_end),
                (Kind::File, Role::Ticket { part }) => this.orphan(one, &part, &beside, still_secs),
                (Kind::File, Role::List) => list(one, &beside, still_secs),
                (kind, _) => Some(Ready::Refuse { seen: one.clone(), reason: no_file(kind).to_owned() }),
            }
        })
    }

    /// Seconds until something may be ready that is not yet, if anything is on its way: when to scan next.
    pub fn next_secs(&self, now_secs: f64) -> Option<f64> {
        let left = |w: &Watched| w.since_secs + self.rules.settle_secs - now_secs;
        self.watched.values().filter(|w| w.scans < 2 || left(w) > 0.0).map(|w| left(w).max(0.0)).min_by(f64::total_cmp)
    }

    fn remember(&mut self, seen: &[Seen], now_secs: f64) {
        let mut before = std::mem::take(&mut self.watched);
        for one in seen {
            let print = Print::of(one);
            let watched = match before.remove(&one.path) {
                Some(known) if known.print == print => Watched { scans: known.scans.saturating_add(1), ..known },
                _ => Watched { print, since_secs: now_secs, scans: 1, is_unclear: false },
            };
            self.watched.insert(one.path.clone(), watched);
        }
    }

    fn is_unclear(&self, ticket: &Path) -> bool {
        self.watched.get(ticket).is_some_and(|watched| watched.is_unclear)
    }

    fn is_settled(&self, seen: &Seen, now_secs: f64) -> bool {
        self.watched.get(&seen.path).is_some_and(|watched| self.stands_still(watched, now_secs))
    }

    fn stands_still(&self, watched: &Watched, now_secs: f64) -> bool {
        watched.scans >= 2 && now_secs - watched.since_secs >= self.rules.settle_secs
    }

    /// What stands in each order folder as if it were one thing: since when nothing has changed in it.
    fn orders_since<'a>(&self, seen: &'a [Seen]) -> HashMap<&'a Path, Watched> {
        let mut orders: HashMap<&Path, Watched> = HashMap::new();
        for one in seen.iter().filter(|one| !one.order.is_empty()) {
            let (Some(folder), Some(&watched)) = (one.path.parent(), self.watched.get(&one.path)) else { continue };
            let order = orders.entry(folder).or_insert(watched);
            order.since_secs = order.since_secs.max(watched.since_secs);
            order.scans = order.scans.min(watched.scans);
        }
        orders
    }

    /// A settled part is ready once what belongs to it has settled too and its end is there.
    fn part(
        &self,
        part: &Seen,
        beside: &Beside,
        now_secs: f64,
        order_still_secs: f64,
        has_end: &mut impl FnMut(&Path, &str) -> io::Result<bool>,
    ) -> Option<Ready> {
        let tickets = beside.tickets_of(&part.path);
        let list = beside.list_of(&part.path);
        if !tickets.iter().copied().chain(list).all(|ticket| self.is_settled(ticket, now_secs)) {
            return None;
        }
        // It leaves with its ticket or list in the same scan: alone it would be printed in guessed numbers.
        if let Some(linked) = tickets.iter().copied().chain(list).find(|beside| beside.is_secret) {
            return Some(Ready::Refuse { seen: part.clone(), reason: of_secret(linked) });
        }
        let still_secs = now_secs - self.watched[&part.path].since_secs;
        let name = display_name(part.path.file_name()?);
        let has_hole = part.allocated < part.size && part.size > SMALL_BYTES;
        if has_hole && still_secs < HOLE_SETTLES * self.rules.settle_secs {
            return None;
        }
        let unfinished = !has_end(&part.path, &name).unwrap_or(false);
        if unfinished && still_secs < self.rules.unfinished_secs {
            return None;
        }
        let list_since = list.and_then(|list| self.watched.get(&list.path)).map(|watched| watched.since_secs);
        let still_secs = list_since.map_or(order_still_secs, |since| order_still_secs.min(now_secs - since));
        let tickets = tickets.into_iter().cloned().collect();
        Some(Ready::Part { part: part.clone(), tickets, list: list.cloned(), said: None, still_secs, unfinished })
    }

    /// A ticket without its part, once it has waited long enough.
    fn orphan(&self, ticket: &Seen, part: &Path, beside: &Beside, still_secs: f64) -> Option<Ready> {
        if beside.is_led(ticket) || still_secs < self.rules.orphan_secs {
            return None;
        }
        let name = display_name(part.file_name()?);
        let what = match self.is_unclear(&ticket.path) {
            true => format!("several parts were called {name:?}, so it was used for none of them"),
            false => format!("no such part came within {:.0} s", self.rules.orphan_secs),
        };
        let reason = format!(
            "This is a ticket for a part {name:?}, but {what}. \
             Drop the part and the ticket together, the ticket named like the whole part file with .toml or .json added."
        );
        Some(Ready::Refuse { seen: ticket.clone(), reason })
    }
}

/// An order list is not taken but looked at, as long as it serves; a folder has one.
fn list(list: &Seen, beside: &Beside, still_secs: f64) -> Option<Ready> {
    if beside.list_of(&list.path) != Some(list) {
        let reason = "There is another order.csv in this folder, in other letters. Put all rows into one list.";
        return Some(Ready::Refuse { seen: list.clone(), reason: reason.to_owned() });
    }
    Some(Ready::List { list: list.clone(), quiet_secs: still_secs })
}

/// A hard link may be made by somebody who may not read the file himself.
fn of_secret(seen: &Seen) -> String {
    let name = display_name(seen.path.file_name().unwrap_or_default());
    format!(
        "{name} has another name elsewhere (it is a hard link) and is not for everybody to read, so nestd does not read it, \
         nor print what it would speak for. Drop a copy of the file."
    )
}

/// Why a thing that is no file is refused.
fn no_file(kind: Kind) -> &'static str {
    match kind {
        Kind::File => "This is a file.",
        Kind::Symlink => "This is a symbolic link; nestd does not follow links. Drop the file itself.",
        Kind::Directory => {
            "This is a folder with the name of a part file, or one that lies too deep. A folder is an order: \
             give it another name and drop it right into the hot folder."
        }
        Kind::Socket => "This is a socket, not a file. Drop STL or 3MF files.",
        Kind::Fifo => "This is a named pipe, not a file. Drop STL or 3MF files.",
        Kind::Device => "This is a device, not a file. Drop STL or 3MF files.",
    }
}

#[cfg(test)]
#[path = "settle_tests.rs"]
mod tests;
