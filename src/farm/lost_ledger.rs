//! A missing, damaged or outdated ledger: how it is detected, and which alert it raises.

use super::{alert::AlertKind, lease_holder, ledger_freshness::LedgerBehindError};
use crate::{intake, ledger::LedgerError, settings::Settings};

/// The ledger is missing, although its farm has worked before.
#[derive(Debug, thiserror::Error)]
#[error("{detail}. {}", AlertKind::LedgerLost.remedy())]
pub struct LostLedgerError {
    /// How this was detected.
    pub detail: String,
}

/// The alert for a failure of the ledger: its kind and detail; `None` = the ledger is not the cause.
pub fn ledger_alert(failure: &anyhow::Error) -> Option<(AlertKind, String)> {
    if let Some(LostLedgerError { detail }) = failure.downcast_ref() {
        return Some((AlertKind::LedgerLost, detail.clone()));
    }
    if let Some(LedgerBehindError { detail }) = failure.downcast_ref() {
        return Some((AlertKind::LedgerBehind, detail.clone()));
    }
    failure.chain().find_map(|error| match error.downcast_ref()? {
        LedgerError::Damaged { path, what } => Some((AlertKind::LedgerDamaged, format!("{}: {what}", path.display()))),
        LedgerError::Corrupt(what) => Some((AlertKind::LedgerDamaged, what.clone())),
        LedgerError::Replaced { what, .. } => Some((AlertKind::LedgerReplaced, what.clone())),
        _ => None,
    })
}

/// How it is known that a ledger existed where there is none now; `None` = there is one, or there never was one.
pub fn detect_lost_ledger(settings: &Settings) -> Option<String> {
    let path = &settings.ledger;
    match std::fs::metadata(path) {
        Ok(meta) if meta.len() > 0 => return None,
        // If it cannot be examined, opening it reports the error.
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => return None,
        _ => {}
    }
    let is_in_use =
        |folder: &str| intake::files_below(&settings.state_dir.join(folder)).is_ok_and(|files| !files.is_empty());
    let known_by = if is_in_use("store") {
        "files that were taken are in the store"
    } else if settings.state_dir.join(lease_holder::FARM_ID_FILE).exists() {
        "this farm has worked before"
    } else {
        return None;
    };
    Some(format!("there is no ledger at {}, but {known_by}", path.display()))
}
