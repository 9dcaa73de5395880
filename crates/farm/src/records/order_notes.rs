//! Notes of orders that came by request, beside the files that were put for them. An order that was answered is told by its note until each of
//! its lines has a part, of which the store tells: a ledger that is put back to a time before the order learns of it again.
//!
//! The ledger has the order first, then its note is durable, then the answer is sent. So a note never tells of an order that nobody took.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};
use build_file::format_count;
use intake::{PutContents, ordered_request_id};
use ledger::{AnsweredRequest, Ledger, NewOrderRequest, OrderedLine};
use serde::{Deserialize, Serialize};

use super::reconcile_report::ReconcileReport;

/// How the name of a note ends.
const SUFFIX: &str = ".json";

/// The note of an order.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct OrderNote {
    client: String,
    key: String,
    answered: AnsweredRequest,
    /// The lines that had no part when it was written.
    lines: Vec<OrderedLine>,
}

/// Notes an order that the ledger has, durably, unless all its lines are parts.
///
/// # Errors
/// The ledger cannot be read, or the folder of state cannot be written.
pub async fn note_order(
    ledger: &Ledger,
    state_dir: &Path,
    client: &str,
    key: &str,
    answered: &AnsweredRequest,
) -> Result<()> {
    let lines = ledger.arriving_lines_of_request(&ordered_request_id(client, key, &answered.fingerprint)).await?;
    if lines.is_empty() {
        return Ok(());
    }
    let (client, key, answered) = (client.to_owned(), key.to_owned(), answered.clone());
    let note = OrderNote { client, key, answered, lines };
    let state_dir = state_dir.to_owned();
    tokio::task::spawn_blocking(move || note.write(&state_dir)).await.context("a step ended")?
}

/// Takes lines out of the notes that are parts by now, or were cancelled. A note without lines is removed.
///
/// # Errors
/// The ledger or a note cannot be read, or a note cannot be written.
pub async fn update_order_notes(ledger: &Ledger, state_dir: &Path) -> Result<()> {
    for (path, note) in read_notes(state_dir)? {
        let Some(mut note) = note else { continue };
        let arriving = ledger.arriving_lines_of_request(&note.request_id()).await?;
        let before = note.lines.len();
        note.lines.retain(|line| arriving.iter().any(|one| one.claim == line.claim));
        match note.lines.len() {
            0 => fs::remove_file(&path).with_context(|| format!("removing {}", path.display()))?,
            lines if lines < before => note.write(state_dir)?,
            _ => {}
        }
    }
    Ok(())
}

/// Lines in the notes that the ledger does not know: the machine of each, and a description.
pub(super) async fn find_unknown_lines(ledger: &Ledger, state_dir: &Path) -> Result<Vec<(String, String)>> {
    let mut unknown = Vec::new();
    for note in read_notes(state_dir)?.into_iter().filter_map(|(_, note)| note) {
        let lines = note.unknown_lines(ledger).await?;
        unknown.extend(lines.iter().map(|line| (line.machine.clone(), describe_line(line))));
    }
    Ok(unknown)
}

/// Takes in the orders of the notes that the ledger does not know. A line whose part it has by now is no second part.
pub(super) async fn take_in_orders(ledger: &Ledger, state_dir: &Path, found: &mut ReconcileReport) -> Result<()> {
    for (path, note) in read_notes(state_dir)? {
        let Some(note) = note else {
            found.doubts.push(format!(
                "{} tells of an order that was taken, and cannot be read: ask who orders by request whether an order is missing",
                path.display()
            ));
            continue;
        };
        let lines = note.unknown_lines(ledger).await?;
        if lines.is_empty() {
            continue;
        }
        found.done.extend(lines.iter().map(|line| {
            let copies = format_count(line.copies, "copy", "copies");
            format!(
                "{} ({copies}, for {}) was taken after the backup was made and was no part yet; it is taken in and arrives",
                describe_line(line),
                line.machine
            )
        }));
        let order = NewOrderRequest { client: note.client, key: note.key, answered: note.answered, lines };
        ledger.record_order_request(&order).await?;
    }
    Ok(())
}

fn describe_line(line: &OrderedLine) -> String {
    format!("{} of order {}, ordered by {}", line.name, line.order_name, line.client)
}

impl OrderNote {
    fn request_id(&self) -> String {
        ordered_request_id(&self.client, &self.key, &self.answered.fingerprint)
    }

    fn write(&self, state_dir: &Path) -> Result<()> {
        let folder = PutContents::of_farm(state_dir).create_orders_folder()?;
        let path = folder.join(self.request_id() + SUFFIX);
        let text = serde_json::to_string(self)?;
        intake::write_file_atomically(&path, text.as_bytes()).with_context(|| format!("writing {}", path.display()))
    }

    async fn unknown_lines(&self, ledger: &Ledger) -> Result<Vec<OrderedLine>> {
        let claims: Vec<String> = self.lines.iter().map(|line| line.claim.clone()).collect();
        let unknown = ledger.unknown_ordered_lines(&claims).await?;
        Ok(self.lines.iter().filter(|line| unknown.contains(&line.claim)).cloned().collect())
    }
}

/// The notes, each with its path; `None` = it cannot be read as one.
fn read_notes(state_dir: &Path) -> Result<Vec<(PathBuf, Option<OrderNote>)>> {
    let folder = PutContents::of_farm(state_dir).orders_folder();
    let failed = || format!("listing {}", folder.display());
    let entries = match fs::read_dir(&folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        other => other.with_context(failed)?,
    };
    let mut notes = Vec::new();
    for entry in entries {
        let path = entry.with_context(failed)?.path();
        if !path.file_name().is_some_and(|name| name.to_string_lossy().ends_with(SUFFIX)) {
            continue;
        }
        match fs::read(&path) {
            // Its last line became a part meanwhile.
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            read => {
                let text = read.with_context(|| format!("reading {}", path.display()))?;
                let note = serde_json::from_slice(&text).ok();
                notes.push((path, note));
            }
        }
    }
    notes.sort_by(|(one, _), (other, _)| one.cmp(other));
    Ok(notes)
}
