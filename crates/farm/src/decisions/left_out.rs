//! Who is not in the next build although somebody counts on it: copies that stood in the open build and were put out,
//! and parts of the highest priority. They are told at once, with the reason: as an event, in the log, and in
//! `STATUS.txt` until they are in a build. Who goes first is defined in `ledger/rows/precedence`.

use std::collections::BTreeSet;

use build_file::format_count;
use ledger::{EventKind, PartId, PartRow, WaitingPart};

use super::layout::CopyId;

/// A part of this priority must be in the next build.
pub const HIGHEST_PRIORITY: u8 = 100;
/// Greatest number of parts that a notice names.
const MAX_NAMES: usize = 3;

/// Why copies are not in the next build.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LeftOutCause {
    /// They stood in the open build, and others needed their room.
    PutOut,
    /// They are of the highest priority, and find no place beside those before them.
    NoRoom,
}

impl LeftOutCause {
    /// The kind of its event.
    pub fn event_kind(self) -> EventKind {
        match self {
            Self::PutOut => EventKind::PutOut,
            Self::NoRoom => EventKind::NoRoom,
        }
    }
}

/// Copies of a part that are not in the next build, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct LeftOutNotice {
    /// The part.
    pub part: PartId,
    /// Its copies that are left out.
    pub copies: BTreeSet<CopyId>,
    /// Why.
    pub cause: LeftOutCause,
    /// The same as a sentence.
    pub text: String,
}

/// The copies to tell of after a search. `parts` are the parts of the search in order of precedence, `placed` the
/// copies that have a place, `stood` those that stood in the open build before.
pub fn find_left_out(
    parts: &[(&PartRow, &[u32])],
    placed: &BTreeSet<CopyId>,
    stood: &BTreeSet<CopyId>,
) -> Vec<LeftOutNotice> {
    let mut notices = Vec::new();
    for (at, &(part, copies)) in parts.iter().enumerate() {
        let missing = || copies.iter().map(|&copy| (part.id, copy)).filter(|copy| !placed.contains(copy));
        let put_out: BTreeSet<CopyId> = missing().filter(|copy| stood.contains(copy)).collect();
        let before = &parts[..at];
        if !put_out.is_empty() {
            let is_new = |copy: CopyId| placed.contains(&copy) && !stood.contains(&copy);
            let text = format!(
                "{} of {} left the open build{}. {} first in line for the next one.",
                format_count(put_out.len(), "copy", "copies"),
                name_of(part),
                name_parts(before, is_new).map_or(String::new(), |names| format!(" for {names}")),
                if put_out.len() == 1 { "It is" } else { "They are" },
            );
            notices.push(LeftOutNotice { part: part.id, copies: put_out, cause: LeftOutCause::PutOut, text });
        }
        let late: BTreeSet<CopyId> = missing().filter(|copy| !stood.contains(copy)).collect();
        if part.terms.priority == HIGHEST_PRIORITY && !late.is_empty() {
            let why = match name_parts(before, |copy| placed.contains(&copy)) {
                Some(names) => format!("there is no room beside {names}, which goes first"),
                None if placed.iter().any(|copy| copy.0 == part.id) => {
                    "there is no room beside its other copies".to_owned()
                }
                None => "no place was found for it in the empty build volume".to_owned(),
            };
            notices.push(no_room_notice(part, late, &why));
        }
    }
    notices
}

/// The copies of the highest priority that are not even tried: those before them fill the whole volume.
pub fn find_cut_off(waiting: &[WaitingPart], wanted: &BTreeSet<CopyId>) -> Vec<LeftOutNotice> {
    let urgent = waiting.iter().filter(|waiting| waiting.part.terms.priority == HIGHEST_PRIORITY);
    urgent
        .filter_map(|WaitingPart { part, copies }| {
            let late: BTreeSet<CopyId> =
                copies.iter().map(|&copy| (part.id, copy)).filter(|copy| !wanted.contains(copy)).collect();
            let why = "what goes first has the volume of the whole build";
            (!late.is_empty()).then(|| no_room_notice(part, late, why))
        })
        .collect()
}

fn no_room_notice(part: &PartRow, copies: BTreeSet<CopyId>, why: &str) -> LeftOutNotice {
    let text = format!(
        "{} of {} cannot be in the next build: {why}. {} first in line for the one after it.",
        format_count(copies.len(), "copy", "copies"),
        name_of(part),
        if copies.len() == 1 { "It is" } else { "They are" },
    );
    LeftOutNotice { part: part.id, copies, cause: LeftOutCause::NoRoom, text }
}

fn name_of(part: &PartRow) -> String {
    format!("{} (part {}, priority {})", part.name, part.id, part.terms.priority)
}

/// Names the parts with such copies, those of the lowest precedence first; `None` = there is none.
fn name_parts(parts: &[(&PartRow, &[u32])], is_meant: impl Fn(CopyId) -> bool) -> Option<String> {
    let meant: Vec<&PartRow> = (parts.iter())
        .filter(|(part, copies)| copies.iter().any(|&copy| is_meant((part.id, copy))))
        .map(|(part, _)| *part)
        .collect();
    let names: Vec<String> = meant.iter().rev().take(MAX_NAMES).map(|part| name_of(part)).collect();
    match meant.len().saturating_sub(MAX_NAMES) {
        _ if names.is_empty() => None,
        0 => Some(names.join(", ")),
        more => Some(format!("{} and {}", names.join(", "), format_count(more, "other part", "other parts"))),
    }
}

/// What a machine tells in `STATUS.txt` about copies that are not in its next build.
#[derive(Debug, Default)]
pub struct LeftOutNotices(Vec<LeftOutNotice>);

impl LeftOutNotices {
    /// The sentences.
    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|notice| notice.text.as_str())
    }

    /// Adds notices and returns those that were not told before.
    pub fn add_new(&mut self, notices: Vec<LeftOutNotice>) -> Vec<LeftOutNotice> {
        let is_known = |new: &LeftOutNotice| {
            self.0.iter().any(|known| known.part == new.part && known.copies.is_superset(&new.copies))
        };
        let fresh: Vec<LeftOutNotice> = notices.into_iter().filter(|new| !is_known(new)).collect();
        self.0.retain(|known| fresh.iter().all(|new| (new.part, new.cause) != (known.part, known.cause)));
        self.0.extend(fresh.iter().cloned());
        fresh
    }

    /// Forgets notices of which no copy is left out any more.
    pub fn retain_copies(&mut self, is_left_out: impl Fn(&CopyId) -> bool) {
        self.0.retain(|notice| notice.copies.iter().any(&is_left_out));
    }
}
