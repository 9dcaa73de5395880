//! Late words: a ticket or a row of an order list that came after its part was taken. The hot folder only knows that no
//! file in the folder has that name; whether a part of that name was taken before, the ledger knows. So the farm looks it
//! up, applies the change, and then finishes the ticket here.
//!
//! The rule: a file in the folder, settled or not, takes the ticket, however many parts of its name were taken before. Only
//! where there is none, and nothing changed for three settle times, the ticket is offered for a part taken before. It leaves
//! the folder when it is accepted, so it is never used for a later part too. The farm applies first and finishes
//! afterwards: after a crash in between, it is offered again, and the ledger knows it.

use std::{
    ffi::{OsStr, OsString},
    fs, io,
    path::{Path, PathBuf},
};

use jiff::Timestamp;

use super::part_spec::read_orphan_ticket;
use crate::{
    InboxEntry, OrderListTracker, ReceivedTicket, RefuseError, SpecSource, Ticket, TicketError,
    claim::refuse::{io_error, refuse_entry, refuse_list_row},
    display_name,
    folder::{control_file::entry_key, disk},
    lists::{order_list::OrderListRow, served_rows::mark_row_late, ticket::broken_ticket},
    names::{
        code_page::CodePage,
        name::raw_name,
        name_match::{FileNameMatch, NameMatches, fold_name},
    },
};

/// Sub-folder of the archive for tickets that were applied to parts taken before.
const ARCHIVE_DIR: &str = "late-tickets";

/// A ticket, or a row of an order list, whose part is not in its folder.
#[derive(Debug, Clone, PartialEq)]
pub struct LateTicket {
    /// The ticket or the list.
    pub entry: InboxEntry,
    /// Name of the part as the ticket's file name or the row says it: perhaps without extension, in other letters, or with
    /// a path. [`LateTicket::find_part`] finds the part that is meant.
    pub part_name: String,
    /// What it says. An error is a reason to refuse it.
    pub ticket: Result<Ticket, TicketError>,
    /// The same as received. Its source tells tickets from rows.
    pub source: ReceivedTicket,
    /// Distinguishes it from every other one, also after a restart. A file that was written again has another key.
    pub key: String,
    /// Whether it is offered for the last time: if it is not finished before the next scan, it is refused there.
    pub is_last_offer: bool,
    /// Whether the row says itself that its part is not wanted.
    pub is_declined: bool,
    /// In which the name was read. The names of parts in the same bytes are read in it, too.
    page: CodePage,
}

/// What became of a late ticket.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LateTicketEnd {
    /// It was moved or written to this path.
    Moved(PathBuf),
    /// The row of the list is served; the list stays until all its rows are.
    RowServed,
    /// The file changed after it was offered, and is offered again with its new content.
    Changed,
    /// The file is gone, perhaps because an earlier call finished it.
    Gone,
}

impl LateTicket {
    /// When its file came into the folder, or was last changed there.
    pub fn came_at(&self) -> Timestamp {
        Timestamp::from_nanosecond(self.entry.ctime_ns).unwrap_or_default()
    }

    /// The order that its folder stands for, as in the parts taken from there. Empty = none.
    pub fn order(&self) -> &str {
        &self.entry.order
    }

    /// Whether it may mean a part of this order: the order of its own folder, or of a folder below it, as lists name files in
    /// sub-folders too.
    pub fn may_mean_order(&self, order_name: &str) -> bool {
        let is_list = self.source.source == SpecSource::OrderList;
        let below = order_name.strip_prefix(self.order()).and_then(|rest| rest.strip_prefix('/'));
        let said_folder = self.part_name.replace('\\', "/");
        let said_folder = said_folder.rsplit_once('/').map_or("", |(folder, _)| folder);
        let said_folder = fold_name(said_folder.trim_start_matches("./").trim_end_matches('/'));
        let is_end_of = |long: &str, end: &str| long == end || long.ends_with(&format!("/{end}"));
        let is_said = match self.order() {
            "" => said_folder == fold_name(order_name),
            // A folder that the row names decides. The list may have been written on another computer, with the folders there.
            _ => below.map(fold_name).is_some_and(|below| {
                said_folder.is_empty() || is_end_of(&said_folder, &below) || is_end_of(&below, &said_folder)
            }),
        };
        order_name == self.order() || is_list && is_said
    }

    /// A ticket without a part in its folder. `None` = it changed since the scan, or is gone.
    pub fn from_orphan(inbox: &Path, ticket: &InboxEntry, part_name: &OsStr, is_last_offer: bool) -> Option<Self> {
        let (text, parsed) = read_orphan_ticket(inbox, ticket)?;
        let file_name = display_name(ticket.path.file_name()?);
        Some(Self {
            part_name: part_name.to_str().map_or_else(|| display_name(part_name), str::to_owned),
            ticket: parsed,
            source: ReceivedTicket { source: SpecSource::Sidecar, file_name, text },
            key: entry_key(ticket),
            is_last_offer,
            is_declined: false,
            page: CodePage::Unicode,
            entry: ticket.clone(),
        })
    }

    /// The rows of a settled list that name no file of its folder and were not served.
    ///
    /// # Errors
    /// The list cannot be read now.
    pub fn from_list(
        inbox: &Path,
        lists: &mut OrderListTracker,
        list: &InboxEntry,
        is_last_offer: bool,
    ) -> io::Result<Vec<Self>> {
        let (page, rows) = lists.rows_without_file(inbox, list)?;
        let list_name = display_name(list.path.file_name().unwrap_or_default());
        let of_row = |row: OrderListRow| Self {
            ticket: match &row.objection {
                Some(said) => {
                    Err(broken_ticket(&list_name, format!("its row says {said}; `nestd cancel` takes a part out")))
                }
                None => row.ticket.map_err(|why| broken_ticket(&list_name, why)),
            },
            source: ReceivedTicket { source: SpecSource::OrderList, file_name: list_name.clone(), text: row.text },
            key: format!("{}-{}", entry_key(list), &blake3::hash(row.file.as_bytes()).to_hex()[..16]),
            is_declined: row.objection.is_some(),
            part_name: row.file,
            is_last_offer,
            page,
            entry: list.clone(),
        };
        Ok(rows.into_iter().map(of_row).collect())
    }

    /// Finds the part that is meant among the names of parts of the same order, as names in lists are matched with files: in any
    /// case, composed or decomposed, with a path, without extension, or in the bytes of the list. `names` are as the ledger shows
    /// them, each once.
    pub fn find_part(&self, names: &[&str]) -> NamedPart {
        find_named_part(&self.part_name, names, self.page)
    }

    /// Finishes it after its words were applied to a part: a ticket is moved to the archive, the row of a list is marked as
    /// served. Safe to repeat.
    ///
    /// # Errors
    /// The file system reports an error. The ticket is offered again.
    pub fn accept_late_ticket(&self, inbox: &Path, archive_dir: &Path) -> Result<LateTicketEnd, RefuseError> {
        if let Some(end) = self.end_without_file()? {
            return Ok(end);
        }
        if self.source.source == SpecSource::OrderList {
            return self.mark_row(inbox).map(|()| LateTicketEnd::RowServed);
        }
        let relative = self.relative_path(inbox)?;
        let folder = Path::new(ARCHIVE_DIR).join(relative.parent().unwrap_or(Path::new("")));
        disk::create_dirs_beneath(archive_dir, &folder).map_err(|e| io_error("create", &folder, e))?;
        let name = self.entry.path.file_name().unwrap_or_default();
        let moved = disk::move_to_free_name(&self.entry.path, &archive_dir.join(folder), name);
        moved.map(LateTicketEnd::Moved).map_err(|e| io_error("move to the archive", &self.entry.path, e))
    }

    /// Refuses it: a ticket is moved to the error folder beside its reason. The row of a list is written there as a list of
    /// its own, and does not wait in the hot folder any more. Safe to repeat.
    ///
    /// # Errors
    /// The file system reports an error. The ticket is offered again.
    pub fn refuse_late_ticket(
        &self,
        inbox: &Path,
        error_dir: &Path,
        reason: &str,
    ) -> Result<LateTicketEnd, RefuseError> {
        if let Some(end) = self.end_without_file()? {
            return Ok(end);
        }
        if self.source.source == SpecSource::OrderList {
            let order = self.relative_path(inbox)?.parent().unwrap_or(Path::new(""));
            let key = format!("Row: {}", self.key);
            let to = refuse_list_row(&self.entry, order, error_dir, &self.source.text, key, reason)?;
            return self.mark_row(inbox).map(|()| LateTicketEnd::Moved(to));
        }
        refuse_entry(inbox, &self.entry, error_dir, reason).map(LateTicketEnd::Moved)
    }

    fn relative_path(&self, inbox: &Path) -> Result<&Path, RefuseError> {
        let path = &self.entry.path;
        path.strip_prefix(inbox).map_err(|_| io_error("finish", path, io::ErrorKind::InvalidInput.into()))
    }

    fn mark_row(&self, inbox: &Path) -> Result<(), RefuseError> {
        mark_row_late(inbox, &self.entry, &self.part_name)
            .map_err(|e| io_error("mark a row as served of", &self.entry.path, e))
    }

    /// Whether nothing is left to finish.
    fn end_without_file(&self) -> Result<Option<LateTicketEnd>, RefuseError> {
        match fs::symlink_metadata(&self.entry.path) {
            Ok(meta) if disk::is_unchanged(&self.entry, &meta) => Ok(None),
            Ok(_) => Ok(Some(LateTicketEnd::Changed)),
            Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
                Ok(Some(LateTicketEnd::Gone))
            }
            Err(error) => Err(io_error("look at", &self.entry.path, error)),
        }
    }
}

/// A part that a late ticket names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NamedPart {
    /// This name (by index) and no other.
    Only(usize),
    /// No name.
    Missing,
    /// It may be several names.
    Several,
}

fn find_named_part(said: &str, names: &[&str], page: CodePage) -> NamedPart {
    let files: Vec<OsString> = names.iter().map(|name| raw_name(name).unwrap_or_else(|| name.into())).collect();
    let matches = NameMatches::in_code_page(&[said], files.iter().map(OsString::as_os_str), page);
    let mut found = files.iter().enumerate().filter_map(|(at, file)| Some((at, matches.files.get(file)?)));
    match (found.next(), found.next()) {
        (None, _) => NamedPart::Missing,
        (Some((at, FileNameMatch::Only(_))), None) => NamedPart::Only(at),
        _ => NamedPart::Several,
    }
}

#[cfg(test)]
#[path = "tests/late_ticket_tests.rs"]
mod tests;
