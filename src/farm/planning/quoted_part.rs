//! The parts that a quote is asked for: read like dropped files, and put beside the waiting ones as if they had arrived now.

use std::{path::PathBuf, sync::Arc};

use build_file::ReadLimits;
use jiff::Timestamp;
use nester::OrientationLimits;
use solids::Mesh;

use super::super::{
    failure::PartReadError,
    file_fault::{FileTerms, find_file_fault},
    file_request::requested_terms,
    isolated_read::PartReadRequest,
};
use crate::{
    ledger::{
        ClaimedFile, OwedCopies, PartId, PartMeasures, PartRejection, PartRow, PartState, PartTerms, PartTimes,
        RequiredTilts, SolidOfFile,
    },
    settings::MachineProfile,
};

/// Priority of a part whose ticket says none.
const USUAL_PRIORITY: u8 = 50;

/// A file that a quote is asked for.
#[derive(Debug, Clone)]
pub struct QuotedFile {
    /// Its name; its ending tells its format.
    pub name: String,
    /// Where it lies.
    pub path: PathBuf,
    /// Copies of each solid in it.
    pub copies: u32,
}

/// A part that a quote is asked for.
#[derive(Debug, Clone)]
pub struct QuotedPart {
    /// Its row, as if it had arrived now. Its number is that of no part.
    pub row: Arc<PartRow>,
    /// Its mesh.
    pub mesh: Arc<Mesh>,
}

/// Why no quote is made.
#[derive(Debug, thiserror::Error)]
pub enum QuoteError {
    /// A file would be refused, and this is why.
    #[error("{0}")]
    Refused(String),
    /// A file cannot be read now.
    #[error("{0}")]
    TryLater(String),
}

/// Reads the files of a quote. `is_isolated`: in a process of their own each, because they come from outside.
///
/// # Errors
/// One of them cannot be read, or would be refused.
pub fn read_quoted_files(
    profile: &MachineProfile,
    limits: &ReadLimits,
    files: &[QuotedFile],
    is_isolated: bool,
    now: Timestamp,
) -> Result<Vec<QuotedPart>, QuoteError> {
    let mut parts: Vec<QuotedPart> = Vec::new();
    for file in files {
        let request = PartReadRequest {
            file: file.path.clone(),
            name: file.name.clone(),
            unit: None,
            default_unit: profile.intake.unit,
            limits: limits.clone(),
        };
        let contents = if is_isolated { request.read_isolated() } else { request.read_in_process() };
        let contents = contents.map_err(|error| match error {
            PartReadError::TryLater(why) => QuoteError::TryLater(why),
            PartReadError::Refused(_, reason) => QuoteError::Refused(reason),
        })?;
        let terms = FileTerms { limits: machine_limits(profile), unit: None, copies: file.copies };
        if let Some((_, reason)) = find_file_fault(&contents, &terms, profile, limits) {
            return Err(QuoteError::Refused(reason));
        }
        for (index, solid) in contents.solids.into_iter().enumerate() {
            let number = i64::MAX - parts.len() as i64;
            let place = SolidOfFile { object_index: index as u32, object_name: solid.name.clone() };
            let mut row = quoted_row(profile, (PartId(number), &file.name), place, now);
            row.owed.copies = solid.copies.saturating_mul(file.copies);
            if let Some(request) = solid.request.as_deref().and_then(|request| requested_terms(request).ok()) {
                row.terms = row.terms.with_request(&request);
            }
            let [x, y, z] = solid.mesh.bounds().size().to_array();
            row.measures = PartMeasures {
                triangles: Some(solid.mesh.triangles().len() as u64),
                volume_mm3: Some(solid.mesh.volume_mm3()),
                size_x_mm: Some(x),
                size_y_mm: Some(y),
                size_z_mm: Some(z),
            };
            parts.push(QuotedPart { row: Arc::new(row), mesh: Arc::new(solid.mesh) });
        }
    }
    Ok(parts)
}

/// How parts may be turned, by the rules of the machine.
fn machine_limits(profile: &MachineProfile) -> OrientationLimits {
    let turning = &profile.turning;
    OrientationLimits::new(turning.orientation, &turning.keep_up, &turning.not_down)
}

/// The row of a part without its measures, by the rules of the machine.
fn quoted_row(profile: &MachineProfile, (id, name): (PartId, &str), solid: SolidOfFile, now: Timestamp) -> PartRow {
    let limits = machine_limits(profile);
    PartRow {
        id,
        profile: profile.name.clone(),
        name: name.to_owned(),
        solid,
        file: ClaimedFile { claim: String::new(), content_hash: String::new(), bytes: 0, reads: 0 },
        state: PartState::Waiting,
        rejection: PartRejection { reason: String::new(), refusal: None },
        warnings: String::new(),
        owed: OwedCopies {
            copies: 1,
            cancelled_copies: 0,
            put_back_at: None,
            fetch_at: None,
            question: String::new(),
            replaced_by: None,
        },
        terms: PartTerms {
            order_name: String::new(),
            priority: USUAL_PRIORITY,
            due_at: None,
            due_text: String::new(),
            orientation: profile.turning.orientation,
            tilts: RequiredTilts(limits.tilts),
            clearance_mm: None,
            unit: None,
            note: String::new(),
            reference: String::new(),
        },
        measures: PartMeasures { triangles: None, volume_mm3: None, size_x_mm: None, size_y_mm: None, size_z_mm: None },
        times: PartTimes { claimed_at: now.into(), state_at: now.into(), damaged_at: None },
    }
}
