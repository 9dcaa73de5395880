//! The instructions for a claimed part, merged from all sources: its sidecar ticket, the order list of its folder, its
//! file name.

use std::{
    io::{self, Read},
    path::Path,
};

use build_file::{COPIES_QUESTION, is_copies_question};

use crate::{
    ClaimedPart, InboxEntry, ListLookup, Ticket, TicketError,
    claim::dropped::open_dropped_file,
    display_name,
    folder::{
        disk,
        file_role::{LIST_LOOKUP_NAME, has_extension, without_hidden_txt},
    },
    lists::{
        order_list::{MAX_LIST_BYTES, OrderList},
        ticket::broken_ticket,
    },
    names::{
        code_page::decode_candidates,
        copies::{CopiesInName, read_copies_in_file_name},
        copies_doubts::is_count_name,
        unordered_folder::{is_past_name, unwanted_words},
    },
};

/// A longer file is not accepted as a ticket.
const MAX_TICKET_BYTES: u64 = 64 << 10;

/// Asks the technician for a number of copies that was said unclearly.
fn copies_question(why: &str) -> String {
    format!("{COPIES_QUESTION} Taken as 1 copy, because {why}. A ticket with `copies = N` says it.")
}

/// Start of a warning that asks whether the part is wanted at all.
const PRINT_QUESTION: &str = "Is it to be printed? It waits for a yes, because ";

/// Asks whether a part is wanted. It waits for a yes.
fn print_question(why: &str) -> String {
    format!("{PRINT_QUESTION}{why}.")
}

/// Why it is asked whether the part of a warning is wanted (part of a sentence).
pub fn read_print_question(warning: &str) -> Option<&str> {
    let why = warning.strip_prefix(PRINT_QUESTION)?;
    Some(why.strip_suffix('.').unwrap_or(why))
}

/// The source of an instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpecSource {
    /// The file's name.
    Name,
    /// A sidecar ticket.
    Sidecar,
    /// An order list.
    OrderList,
}

impl SpecSource {
    /// The word that the ledger stores.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Name => "name",
            Self::Sidecar => "sidecar",
            Self::OrderList => "order_list",
        }
    }
}

/// A ticket as it was received.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReceivedTicket {
    /// The kind of source.
    pub source: SpecSource,
    /// Name of the file that contained it (or of the part itself), escaped.
    pub file_name: String,
    /// Text as received: the content of the sidecar, the header and row of the list, or the file name.
    pub text: String,
}

/// The merged instructions of all sources. For each field, the sidecar takes precedence over the list, and the list
/// over the name.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PartSpec {
    /// The merged ticket. Its `order` comes from tickets only; the sub-folder is in [`ClaimedPart::order`].
    pub ticket: Ticket,
    /// Its sources, in order of precedence.
    pub sources: Vec<ReceivedTicket>,
    /// Warnings for the technician about probable mistakes, in whole sentences.
    pub warnings: Vec<String>,
    /// The claim of what was taken of the same file before its writer went on.
    pub rewrites: Option<String>,
}

impl ClaimedPart {
    /// Merges the ticket, the order list and the file name. An error is addressed to the technician: the part must be
    /// refused with it, because its number of copies is unknown.
    pub fn read_part_spec(&self) -> Result<PartSpec, TicketError> {
        let mut given = PartSpec::default();
        if let [first, second, ..] = &self.tickets[..] {
            return Err(TicketError::Duplicate { first: display_file_name(first), second: display_file_name(second) });
        }
        for path in &self.tickets {
            let text = read_ticket_text(path).map_err(|error| unreadable_ticket(path, error))?;
            given.merge_ticket(SpecSource::Sidecar, display_file_name(path), parse_ticket_text(path, &text)?, text);
        }
        let asked = self.list.as_ref().map(|path| self.add_list_row(path, &mut given)).transpose()?.flatten();
        let name = self.display_name();
        let said = read_copies_in_file_name(&self.name);
        if let CopiesInName::Said(copies) = said {
            let ticket = Ticket { copies: Some(copies), ..Ticket::default() };
            given.merge_ticket(SpecSource::Name, name.clone(), ticket, name);
        } else if let Some(why) = said.unclear_reason().filter(|_| given.ticket.copies.is_none()) {
            given.warnings.push(copies_question(&why));
        }
        let row = given.sources.iter().find(|source| source.source == SpecSource::OrderList);
        if let Some(row) = row.filter(|_| given.ticket.copies.is_none()) {
            let why = format!("its row in {} names no number of copies", row.file_name);
            given.warnings.push(copies_question(&why));
        }
        given.warnings.extend(asked.filter(|_| given.ticket.copies.is_none()).map(|why| copies_question(&why)));
        let counted = self.order_path.iter().find(|folder| is_count_name(folder));
        let counted = counted
            .filter(|_| given.ticket.copies.is_none() && !given.warnings.iter().any(|one| is_copies_question(one)));
        given
            .warnings
            .extend(counted.map(|name| copies_question(&format!("it lies in a folder called {}", display_name(name)))));
        let past = self.order_path.iter().find(|folder| is_past_name(folder));
        given
            .warnings
            .extend(past.map(|name| print_question(&format!("it lies in a folder called {}", display_name(name)))));
        let not_to_print = unwanted_words(&self.display_name());
        given.warnings.extend(not_to_print.map(|words| print_question(&format!("its name says \"{words}\""))));
        Ok(given)
    }

    /// Adds what the list says. Returns why the number of copies is asked for, if nothing else says it.
    fn add_list_row(&self, path: &Path, given: &mut PartSpec) -> Result<Option<String>, TicketError> {
        let said = match path.file_name() == Some(LIST_LOOKUP_NAME.as_ref()) {
            true => ListLookup::load_from(path).map_err(|error| unreadable_ticket(path, error))?.unwrap_or_default(),
            false => self.look_up_whole_list(path)?,
        };
        given.warnings.extend(said.warnings.iter().cloned());
        given.rewrites.clone_from(&said.rewrites);
        match said.problem.clone() {
            Some(why) if said.is_unlisted => return Err(TicketError::Unlisted(why)),
            Some(why) => return Err(broken_ticket(said.shown_list_name(), why)),
            None => {}
        }
        let list_name = said.shown_list_name().to_owned();
        if let Some(text) = said.row {
            let row = OrderList::parse_single_row(&text);
            let objection = row.as_ref().ok().and_then(|row| row.objection.clone());
            given.warnings.extend(objection.map(|said| print_question(&format!("its row in {list_name} says {said}"))));
            let ticket = row.and_then(|row| row.ticket).map_err(|why| broken_ticket(&list_name, why))?;
            given.merge_ticket(SpecSource::OrderList, list_name, ticket, text);
        }
        Ok(said.question)
    }

    /// Finds the row of the part. A claim of an older nestd holds a copy of the whole list.
    fn look_up_whole_list(&self, path: &Path) -> Result<ListLookup, TicketError> {
        let bytes = read_bytes_up_to(path, MAX_LIST_BYTES).map_err(|error| unreadable_ticket(path, error))?;
        let list = OrderList::parse_for_files(&bytes, &[&self.name]);
        let row = list.row_for_file(&self.name).map_err(|why| broken_ticket(&display_file_name(path), why))?;
        Ok(ListLookup { row: row.map(|row| row.text.clone()), ..ListLookup::default() })
    }
}

/// Reads a sidecar ticket.
pub(super) fn read_ticket_file(path: &Path) -> Result<Ticket, TicketError> {
    let text = read_ticket_text(path).map_err(|error| unreadable_ticket(path, error))?;
    parse_ticket_text(path, &text)
}

impl PartSpec {
    fn merge_ticket(&mut self, source: SpecSource, file_name: String, weaker: Ticket, text: String) {
        self.ticket = std::mem::take(&mut self.ticket).merge_weaker(weaker);
        self.sources.push(ReceivedTicket { source, file_name, text });
    }
}

/// Distinguishes an error of the operating system, which may be temporary, from a fault of the file, which is
/// permanent.
fn unreadable_ticket(path: &Path, error: io::Error) -> TicketError {
    match error.raw_os_error() {
        Some(errno) => TicketError::Unreadable { file: display_file_name(path), errno },
        None => broken_ticket(&display_file_name(path), error.to_string()),
    }
}

/// Reads a ticket of the hot folder that has no part beside it, provided that it did not change since the scan. `None` =
/// it changed or is gone.
pub(super) fn read_orphan_ticket(inbox: &Path, ticket: &InboxEntry) -> Option<(String, Result<Ticket, TicketError>)> {
    let read = || -> io::Result<Option<Vec<u8>>> {
        let file = open_dropped_file(inbox, &ticket.path)?;
        let mut bytes = Vec::new();
        (&file).take(MAX_TICKET_BYTES + 1).read_to_end(&mut bytes)?;
        Ok(disk::is_unchanged(ticket, &file.metadata()?).then_some(bytes))
    };
    let text = match read() {
        Ok(bytes) => ticket_text(bytes?),
        Err(error) if error.kind() == io::ErrorKind::NotFound => return None,
        Err(error) => Err(error),
    };
    let text = text.map_err(|error| unreadable_ticket(&ticket.path, error));
    let parsed = text.clone().and_then(|text| parse_ticket_text(&ticket.path, &text));
    Some((text.unwrap_or_default(), parsed))
}

fn display_file_name(path: &Path) -> String {
    display_name(path.file_name().unwrap_or_default())
}

/// Reads a ticket from its file.
///
/// # Errors
/// It cannot be read, or is no ticket.
pub fn read_ticket(path: &Path) -> Result<Ticket, TicketError> {
    let text = read_ticket_text(path).map_err(|error| unreadable_ticket(path, error))?;
    parse_ticket_text(path, &text)
}

fn parse_ticket_text(path: &Path, text: &str) -> Result<Ticket, TicketError> {
    match has_extension(&without_hidden_txt(path), &["json"]) {
        true => Ticket::from_json(text, &display_file_name(path)),
        false => Ticket::from_toml(text, &display_file_name(path)),
    }
}

/// Reads a text whose encoding is certain: UTF-8, or UTF-16 as some editors write it.
fn read_ticket_text(path: &Path) -> io::Result<String> {
    ticket_text(read_bytes_up_to(path, MAX_TICKET_BYTES)?)
}

fn ticket_text(bytes: Vec<u8>) -> io::Result<String> {
    match &mut decode_candidates(&bytes)[..] {
        _ if bytes.len() as u64 > MAX_TICKET_BYTES => {
            Err(io::Error::other(format!("it is longer than {MAX_TICKET_BYTES} bytes")))
        }
        [reading] => Ok(std::mem::take(&mut reading.text)),
        _ => Err(io::Error::other("it is not UTF-8 text")),
    }
}

fn read_bytes_up_to(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    disk::open_regular_file(path)?.take(most + 1).read_to_end(&mut bytes)?;
    match bytes.len() as u64 > most {
        true => Err(io::Error::other(format!("it is longer than {most} bytes"))),
        false => Ok(bytes),
    }
}
