//! What the test asked for, as it knows it without the ledger: files, operations, and what the printer took.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::PathBuf,
};

/// Copies by BLAKE3 of the dropped file.
pub type CopiesByFile = BTreeMap<String, u32>;

/// A dropped file, which is a line of an order.
#[derive(Debug, Clone)]
pub struct DroppedLine {
    pub name: String,
    /// Folder below the hot folder, "" = none.
    pub folder: String,
    pub bytes: Vec<u8>,
    /// Copies said with it by its name, its ticket or its list; `None` = nothing was said.
    pub said: Option<u32>,
    /// Its longest side as dropped, mm.
    pub size_mm: f64,
    /// It is so small that nobody may print it before a person says yes.
    pub is_speck: bool,
    /// The number of the operation that dropped a late ticket for it.
    pub late_ticket: Option<usize>,
    /// A newer file of its name was dropped, or it is one.
    pub is_revised: bool,
}

/// An operation that a person asked for. Its number is its place; the user `worker<number>` asks for it.
#[derive(Debug, Clone, PartialEq)]
pub enum Asked {
    /// Files were dropped, or something that changes no number of copies.
    Other,
    /// This part: `copies` in all, and in centimetres where its name is given.
    Edit {
        part: i64,
        copies: Option<u32>,
        in_cm: Option<String>,
    },
    /// A ticket for a part that was taken before.
    LateTicket {
        copies: u32,
    },
    /// These parts, all waiting copies or some; and all parts of an order, "" = of none.
    Cancel {
        parts: BTreeSet<i64>,
        order: String,
        copies: Option<u32>,
    },
    Retry {
        part: i64,
    },
    Confirm {
        part: i64,
    },
    /// An outcome: the copies that were told bad by it, and those that count as printed well again.
    Outcome {
        build: i64,
        newly_bad: CopiesByFile,
        returned: CopiesByFile,
    },
}

/// A build file that the printer took.
#[derive(Debug, Clone)]
pub struct TakenBuild {
    /// Where the printer keeps it.
    pub file: PathBuf,
    pub machine: String,
    pub copies: CopiesByFile,
}

/// The user who asks for an operation.
pub fn worker(operation: usize) -> String {
    format!("worker{operation}")
}

/// The operation that a text names by its user.
pub fn named_operation(text: &str) -> Option<usize> {
    let mut rest = text;
    while let Some((_, after)) = rest.split_once("worker") {
        let digits: String = after.chars().take_while(char::is_ascii_digit).collect();
        if after[digits.len()..].starts_with('@')
            && let Ok(number) = digits.parse()
        {
            return Some(number);
        }
        rest = after;
    }
    None
}
