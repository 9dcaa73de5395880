//! What is said about a claimed part, from all that may say it: its sidecar, the order list of its folder, its name.

use std::{
    io::{self, Read},
    path::Path,
};

use super::{
    Claim, Ticket, TicketError,
    copies::{MAX_COPIES, unclear_copies},
    copies_in_name, disk, display_name,
    order_list::OrderList,
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
            let list = OrderList::read(path).map_err(|error| unreadable(path, error))?;
            if let Some(row) = list.row_for(&self.name).map_err(|why| broken(&shown(path), why))? {
                let ticket = row.ticket.clone().map_err(|why| broken(&shown(path), why))?;
                given.add(Source::OrderList, shown(path), ticket, row.text.clone());
            }
        }
        let name = self.display_name();
        if let Some(copies) = copies_in_name(&name) {
            given.add(Source::Name, name.clone(), Ticket { copies: Some(copies), ..Ticket::default() }, name);
        } else if let (None, Some(word)) = (given.ticket.copies, unclear_copies(&name)) {
            given.warnings.push(format!(
                "Its name ends in \"{word}\", which is no clear number of copies from 1 to {MAX_COPIES}: taken as 1 copy."
            ));
        }
        Ok(given)
    }
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

fn read_text(path: &Path) -> io::Result<String> {
    let mut bytes = Vec::new();
    disk::open_regular(path)?.take(MAX_TICKET_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_TICKET_BYTES {
        return Err(io::Error::other(format!("it is longer than {MAX_TICKET_BYTES} bytes")));
    }
    String::from_utf8(bytes).map_err(|_| io::Error::other("it is not UTF-8 text"))
}
