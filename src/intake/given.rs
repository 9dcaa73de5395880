//! What is said about a claimed part, from all that may say it: its sidecar, the order list of its folder, its name.

use super::Ticket;

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
    /// The merged ticket.
    pub ticket: Ticket,
    /// Where it is from, strongest first.
    pub sources: Vec<TicketSource>,
}
