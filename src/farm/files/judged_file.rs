//! A file is judged before an order is taken: what would be refused later is refused at once, with the same reason.

use std::{fs, path::Path};

use build_file::ReadLimits;
use intake::Ticket;

use super::{
    file_fault::{FileTerms, find_file_fault},
    isolated_read::PartReadRequest,
};
use crate::{farm::alerts::failure::PartReadError, settings::MachineProfile};

/// A larger file is judged when it is taken: reading it takes longer than a client waits.
const MAX_JUDGED_BYTES: u64 = 64 << 20;

/// Why a file cannot be printed as its ticket asks, in whole sentences: what its reason file would say. It is read in a separate process.
/// `None` = nothing speaks against it so far.
pub fn judge_file(
    file: &Path,
    name: &str,
    ticket: &Ticket,
    profile: &MachineProfile,
    limits: &ReadLimits,
) -> Option<String> {
    if fs::metadata(file).map_or(0, |found| found.len()) > MAX_JUDGED_BYTES {
        return None;
    }
    let errand = PartReadRequest {
        file: file.to_owned(),
        name: name.to_owned(),
        unit: ticket.unit,
        fixed_unit: profile.intake.unit,
        limits: limits.clone(),
    };
    let contents = match errand.read_isolated() {
        Ok(contents) => contents,
        Err(PartReadError::Refused(_, reason)) => return Some(reason),
        Err(PartReadError::TryLater(_)) => return None,
    };
    find_file_fault(&contents, &FileTerms::of_ticket(ticket, profile), profile, limits).map(|(_, reason)| reason)
}
