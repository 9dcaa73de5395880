//! The alerts as others than the daemon read them: in a file of the state folder, which needs no ledger, and in the row of each other node.

use std::{fs, io, io::Write, os::unix::fs::FileExt, path::Path};

use ledger::NodeRow;
use settings::Settings;

use super::alert::FarmAlert;

/// Name of the file in the state folder.
pub(super) const FILE: &str = "attention.json";
/// The length of the file is a multiple of this.
pub(super) const ROOM_BYTES: usize = 1 << 14;

/// Writes the alerts into a file with some room at its end: on a full disk, of all times, the next ones are written into
/// that room.
pub(super) fn write_alerts(state_dir: &Path, alerts: &[FarmAlert]) -> io::Result<()> {
    let mut text = serde_json::to_string_pretty(alerts)?.into_bytes();
    text.resize(text.len().next_multiple_of(ROOM_BYTES), b' ');
    let written = tempfile::Builder::new().prefix(".attention-").tempfile_in(state_dir).and_then(|mut file| {
        file.write_all(&text)?;
        Ok(file.persist(state_dir.join(FILE))?)
    });
    match written {
        Err(error) if error.kind() == io::ErrorKind::StorageFull => overwrite_alerts(&state_dir.join(FILE), &text),
        other => other.map(drop),
    }
}

/// Overwrites the file where it is. A crash may leave it torn: it then counts as empty until the next alert.
pub(super) fn overwrite_alerts(path: &Path, text: &[u8]) -> io::Result<()> {
    let file = fs::File::options().write(true).open(path)?;
    let room = usize::try_from(file.metadata()?.len()).unwrap_or(usize::MAX);
    if text.len() > room {
        return Err(io::ErrorKind::StorageFull.into());
    }
    let mut padded = text.to_vec();
    padded.resize(room, b' ');
    file.write_all_at(&padded, 0)
}

/// The alerts that the daemon stored last; empty if there are none or they cannot be read.
pub fn read_stored_alerts(state_dir: &Path) -> Vec<FarmAlert> {
    let text = fs::read_to_string(state_dir.join(FILE)).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

/// The alerts of this node, and those of the other nodes that run. What several see is told once.
pub fn alerts_of_farm<'n>(settings: &Settings, nodes: impl IntoIterator<Item = &'n NodeRow>) -> Vec<FarmAlert> {
    let mut alerts = read_stored_alerts(&settings.state_dir);
    for node in nodes.into_iter().filter(|node| node.alive && node.name != settings.node.name) {
        // One of a kind that only a newer version knows is left out.
        let its: Vec<serde_json::Value> = serde_json::from_str(&node.alerts).unwrap_or_default();
        for alert in its.into_iter().filter_map(|alert| serde_json::from_value::<FarmAlert>(alert).ok()) {
            let is_told = |told: &FarmAlert| {
                (told.kind, &told.machine, &told.detail) == (alert.kind, &alert.machine, &alert.detail)
            };
            if !alerts.iter().any(is_told) {
                alerts.push(FarmAlert { node: node.name.clone(), ..alert });
            }
        }
    }
    alerts
}
