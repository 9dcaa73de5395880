//! A ledger that is gone, damaged or behind: how that is known, and what it is to people.

use super::{attention::Attention, current::Behind, owner};
use crate::{intake, ledger::LedgerError, settings::Settings};

/// The ledger is gone, and its farm is not.
#[derive(Debug, thiserror::Error)]
#[error("{detail}. {}", Attention::LedgerLost.remedy())]
pub struct Lost {
    /// How it is known.
    pub detail: String,
}

/// What a failure is to people, if it is the ledger's: the kind of notice, and what was found.
pub fn of_the_ledger(failure: &anyhow::Error) -> Option<(Attention, String)> {
    if let Some(Lost { detail }) = failure.downcast_ref() {
        return Some((Attention::LedgerLost, detail.clone()));
    }
    if let Some(Behind { detail }) = failure.downcast_ref() {
        return Some((Attention::LedgerBehind, detail.clone()));
    }
    failure.chain().find_map(|error| match error.downcast_ref()? {
        LedgerError::Damaged { path, what } => Some((Attention::LedgerDamaged, format!("{}: {what}", path.display()))),
        LedgerError::Corrupt(what) => Some((Attention::LedgerDamaged, what.clone())),
        LedgerError::Replaced { what, .. } => Some((Attention::LedgerReplaced, what.clone())),
        _ => None,
    })
}

/// How it is known that there was a ledger where none is now; `None` = there is one, or there never was.
pub fn lost(settings: &Settings) -> Option<String> {
    let path = &settings.ledger;
    match std::fs::metadata(path) {
        Ok(meta) if meta.len() > 0 => return None,
        // What cannot be looked at is told by opening it.
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => return None,
        _ => {}
    }
    let holds =
        |folder: &str| intake::files_below(&settings.state_dir.join(folder)).is_ok_and(|files| !files.is_empty());
    let known_by = if holds("store") {
        "files that were taken are in the store"
    } else if settings.state_dir.join(owner::FARM).exists() {
        "this farm has worked before"
    } else {
        return None;
    };
    Some(format!("there is no ledger at {}, but {known_by}", path.display()))
}
