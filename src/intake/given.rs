//! What is said about a claimed part, from all that may say it: its sidecar, the order list of its folder, its name.

use std::{
    io::{self, Read},
    path::Path,
};

use super::{
    Claim, Said, Ticket, TicketError,
    beside::{LIST_NAME, SAID_NAME},
    code_page::readings,
    copies::{MAX_COPIES, unclear_copies},
    copies_in_name, disk, display_name,
    order_list::{MAX_LIST_BYTES, OrderList},
    ticket::broken,
};

/// A longer ticket is none.
const MAX_TICKET_BYTES: u64 = 64 << 10;

/// Who said it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// The file's name.
    Name,
    /// A sidecar ticket.
    Sidecar,
    /// An `order.csv`.
    OrderList,
}

impl Source {
    /// The word of the ledger.
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
pub struct TicketSource {
    /// Who said it.
    pub source: Source,
    /// Name of the file it stood in (or of the part itself), escaped.
    pub file_name: String,
    /// As received: the sidecar's text, the list's header and row, or the name.
    pub text: String,
}

/// What all sources together say: the sidecar wins over the list, the list over the name, word by word.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Given {
    /// The merged ticket; its `order` is only what a ticket says, the sub-folder is [`Claim::order`].
    pub ticket: Ticket,
    /// Where it is from, strongest first.
    pub sources: Vec<TicketSource>,
    /// What was probably meant otherwise, for the technician, in whole sentences.
    pub warnings: Vec<String>,
}

impl Claim {
    /// What is said about it by ticket, order list and name. An error is for the technician: the part is to be refused
    /// with it, for nobody knows how many copies were meant.
    pub fn given(&self) -> Result<Given, TicketError> {
        let mut given = Given::default();
        if let [first, second, ..] = &self.tickets[..] {
            return Err(TicketError::Two { first: shown(first), second: shown(second) });
        }
        for path in &self.tickets {
            let text = read_text(path).map_err(|error| unreadable(path, error))?;
            given.add(Source::Sidecar, shown(path), parse(path, &text)?, text);
        }
        if let Some(path) = &self.list {
            self.add_what_the_list_says(path, &mut given)?;
        }
        let name = self.display_name();
        if let Some(copies) = copies_in_name(&name) {
            given.add(Source::Name, name.clone(), Ticket { copies: Some(copies), ..Ticket::default() }, name);
        } else if let (None, Some(word)) = (given.ticket.copies, unclear_copies(&name)) {
            given.warnings.push(format!(
                "Its name ends in \"{word}\", which is no clear number of copies from 1 to {MAX_COPIES}: taken as 1 copy."
            ));
        }
        if given.ticket.copies.is_none() && given.sources.iter().any(|source| source.source == Source::OrderList) {
            given.warnings.push(format!("Its row in {LIST_NAME} names no number of copies: taken as 1 copy."));
        }
        Ok(given)
    }

    fn add_what_the_list_says(&self, path: &Path, given: &mut Given) -> Result<(), TicketError> {
        let said = match path.file_name() == Some(SAID_NAME.as_ref()) {
            true => Said::load(path).map_err(|error| unreadable(path, error))?.unwrap_or_default(),
            false => self.whole_list(path)?,
        };
        given.warnings.extend(said.warnings);
        match said.problem {
            Some(why) if said.is_unlisted => return Err(TicketError::Unlisted(why)),
            Some(why) => return Err(broken(LIST_NAME, why)),
            None => {}
        }
        if let Some(text) = said.row {
            let ticket = OrderList::alone(&text).map_err(|why| broken(LIST_NAME, why))?;
            given.add(Source::OrderList, LIST_NAME.to_owned(), ticket, text);
        }
        Ok(())
    }

    /// A claim of an older nestd holds a copy of the whole list.
    fn whole_list(&self, path: &Path) -> Result<Said, TicketError> {
        let bytes = read_bytes(path, MAX_LIST_BYTES).map_err(|error| unreadable(path, error))?;
        let list = OrderList::parse_beside(&bytes, &[&self.name]);
        let row = list.row_for(&self.name).map_err(|why| broken(&shown(path), why))?;
        Ok(Said { row: row.map(|row| row.text.clone()), ..Said::default() })
    }
}

/// A sidecar, read.
pub(super) fn read_ticket(path: &Path) -> Result<Ticket, TicketError> {
    let text = read_text(path).map_err(|error| unreadable(path, error))?;
    parse(path, &text)
}

impl Given {
    fn add(&mut self, source: Source, file_name: String, weaker: Ticket, text: String) {
        self.ticket = std::mem::take(&mut self.ticket).or(weaker);
        self.sources.push(TicketSource { source, file_name, text });
    }
}

/// What the system said may pass; what was found in the file does not.
fn unreadable(path: &Path, error: io::Error) -> TicketError {
    match error.raw_os_error() {
        Some(errno) => TicketError::Unreadable { file: shown(path), errno },
        None => broken(&shown(path), error.to_string()),
    }
}

fn shown(path: &Path) -> String {
    display_name(path.file_name().unwrap_or_default())
}

fn parse(path: &Path, text: &str) -> Result<Ticket, TicketError> {
    match path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) {
        true => Ticket::from_json(text, &shown(path)),
        false => Ticket::from_toml(text, &shown(path)),
    }
}

/// Text that can be read one way only: UTF-8, or UTF-16 as some editors write it.
fn read_text(path: &Path) -> io::Result<String> {
    match &mut readings(&read_bytes(path, MAX_TICKET_BYTES)?)[..] {
        [text] => Ok(std::mem::take(text)),
        _ => Err(io::Error::other("it is not UTF-8 text")),
    }
}

fn read_bytes(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    disk::open_regular(path)?.take(most + 1).read_to_end(&mut bytes)?;
    match bytes.len() as u64 > most {
        true => Err(io::Error::other(format!("it is longer than {most} bytes"))),
        false => Ok(bytes),
    }
}
