//! A missing, damaged or outdated ledger: how it is detected, and which alert it raises.

use std::path::{Path, PathBuf};

use ledger::{LedgerError, ServerError};
use settings::Settings;

use super::ledger_freshness::LedgerBehindError;
use crate::{
    alerts::alert::AlertKind,
    leases::{lease_holder, state_lock},
};

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
        LedgerError::Locked { by } => Some((AlertKind::LedgerLocked, by.clone())),
        LedgerError::Replaced { what, .. } | LedgerError::Overwritten { what, .. } => {
            Some((AlertKind::LedgerReplaced, what.clone()))
        }
        LedgerError::Server(ServerError::Unreachable(what)) => Some((AlertKind::LedgerUnreachable, what.clone())),
        LedgerError::Server(ServerError::ChangesWait { holder }) => Some((AlertKind::ChangesWait, holder.clone())),
        LedgerError::Server(ServerError::RepairDue { nodes }) => Some((AlertKind::RepairDue, nodes.clone())),
        LedgerError::Server(error @ ServerError::Behind) => Some((AlertKind::LedgerBehind, error.to_string())),
        LedgerError::Server(error @ ServerError::TakenOver) => Some((AlertKind::LedgerTakenOver, error.to_string())),
        _ => None,
    })
}

/// How it is known that a ledger existed where [`Ledger::is_missing`](ledger::Ledger::is_missing) has found none;
/// `None` = there never was one.
pub fn detect_lost_ledger(settings: &Settings) -> Option<String> {
    let is_in_use =
        |folder: &str| intake::files_below(&settings.state_dir.join(folder)).is_ok_and(|files| !files.is_empty());
    let known_by = if is_in_use("store") {
        "files that were taken are in the store"
    } else if settings.state_dir.join(lease_holder::FARM_ID_FILE).exists() {
        "this farm has worked before"
    } else {
        return None;
    };
    let saved = (settings.ledger.file().and_then(newest_saved_ledger))
        .map(|saved| format!("; nestd saved all that it knew as {}, which is newer than any backup", saved.display()));
    Some(format!("there is no ledger at {}, but {known_by}{}", settings.ledger, saved.unwrap_or_default()))
}

/// The name of a copy that the daemon saves when its ledger is removed: this, after the ledger's name, and the time.
pub(crate) const SAVED: &str = ".saved-";

/// The copy of the ledger that the daemon saved last when the ledger was removed.
fn newest_saved_ledger(ledger: &Path) -> Option<PathBuf> {
    let start = format!("{}{SAVED}", ledger.file_name()?.to_str()?);
    let names =
        std::fs::read_dir(ledger.parent()?).ok()?.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let newest = names.filter(|name| name.starts_with(&start) && name.ends_with('Z')).max()?;
    Some(ledger.with_file_name(newest))
}

/// Why a command cannot use the ledger of a farm that has lost it: what is known, what helps, and whether a daemon runs.
pub fn lost_ledger_text(settings: &Settings) -> Option<String> {
    let detail = detect_lost_ledger(settings)?;
    let daemon = match state_lock::is_held(&settings.state_dir) {
        true => "A daemon runs and takes and publishes nothing: stop it first.",
        false => "No daemon runs, and none starts.",
    };
    Some(format!("{detail}. {daemon} {}", AlertKind::LedgerLost.remedy()))
}
