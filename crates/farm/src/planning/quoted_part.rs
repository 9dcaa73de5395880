//! The parts that a quote is asked for: read like dropped files, and put beside the waiting ones as if they had arrived now.

use std::{
    collections::{HashMap, hash_map::Entry},
    path::{Path, PathBuf},
    sync::Arc,
    time::Instant,
};

use build_file::{LengthUnit, PartFileContents, PartFileSolid, ReadLimits};
use intake::Ticket;
use jiff::Timestamp;
use ledger::{
    ClaimedFile, OwedCopies, PartId, PartMeasures, PartMending, PartRefusal, PartRow, PartState, PartTerms, PartTimes,
    RequiredTilts, SolidOfFile,
};
use settings::MachineProfile;
use solids::Mesh;

use crate::{
    alerts::failure::PartReadError,
    files::{
        file_fault::{FileTerms, find_file_fault, requested_terms},
        isolated_read::PartReadRequest,
        mending::{allowed_by_ticket, mend_solids},
    },
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
    /// What its ticket would say.
    pub ticket: Ticket,
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
    /// A part would wait for its material, and this is why.
    #[error("{0}")]
    AwaitsMaterial(String),
    /// A file cannot be read now.
    #[error("{0}")]
    TryLater(String),
}

/// As what a file is read: its path, its unit, whether it may be mended, and the ending of its name.
type FileReading<'f> = (&'f Path, Option<LengthUnit>, Option<bool>, Option<String>);

/// Reads the files of a quote, each once. `isolated_until`: in a process of their own each, because they come from outside, and none
/// is begun later.
///
/// # Errors
/// One of them cannot be read, or would be refused.
pub fn read_quoted_files(
    profile: &MachineProfile,
    limits: &ReadLimits,
    files: &[QuotedFile],
    isolated_until: Option<Instant>,
    now: Timestamp,
) -> Result<Vec<QuotedPart>, QuoteError> {
    let (mut parts, mut triangles): (Vec<QuotedPart>, u64) = Default::default();
    // The ending of its name tells the format where the content does not.
    let mut known: HashMap<FileReading<'_>, PartFileContents> = HashMap::new();
    for file in files {
        let terms = FileTerms::of_ticket(&file.ticket, profile);
        let contents = match known.entry((&file.path, terms.unit, file.ticket.mend, ending(&file.name))) {
            Entry::Occupied(known) => &*known.into_mut(),
            Entry::Vacant(place) => {
                let mut contents = read_quoted_file(profile, limits, file, isolated_until)?;
                mend_solids(&mut contents, allowed_by_ticket(&file.ticket, profile).as_deref());
                triangles += contents.solids.iter().map(|solid| solid.mesh.triangles().len() as u64).sum::<u64>();
                &*place.insert(contents)
            }
        };
        if triangles > limits.max_triangles {
            let most = limits.max_triangles;
            return Err(QuoteError::Refused(format!(
                "the files of a quote have {most} triangles at most together (limits.max_triangles): ask for fewer at a time"
            )));
        }
        if let Some((_, reason)) = find_file_fault(contents, &terms, profile, limits) {
            return Err(QuoteError::Refused(reason));
        }
        for (index, solid) in contents.solids.iter().enumerate() {
            let number = PartId(i64::MAX - parts.len() as i64);
            let row = quoted_row(profile, &terms, (number, file), (index as u32, solid), now);
            parts.push(QuotedPart { row: Arc::new(row), mesh: solid.mesh.clone() });
        }
    }
    Ok(parts)
}

/// The ending of a name, in small letters.
fn ending(name: &str) -> Option<String> {
    Some(Path::new(name).extension()?.to_string_lossy().to_lowercase())
}

fn read_quoted_file(
    profile: &MachineProfile,
    limits: &ReadLimits,
    file: &QuotedFile,
    isolated_until: Option<Instant>,
) -> Result<PartFileContents, QuoteError> {
    let request = PartReadRequest {
        file: file.path.clone(),
        name: file.name.clone(),
        unit: file.ticket.unit,
        fixed_unit: profile.intake.unit,
        limits: limits.clone(),
    };
    let contents = match isolated_until {
        Some(until) if Instant::now() > until => {
            return Err(QuoteError::TryLater(
                "it takes too long to read all these files: ask for fewer at a time".to_owned(),
            ));
        }
        Some(_) => request.read_isolated(),
        None => request.read_in_process(),
    };
    contents.map_err(|error| match error {
        PartReadError::TryLater(why) => QuoteError::TryLater(why),
        PartReadError::Refused(_, reason) => QuoteError::Refused(reason),
    })
}

/// The row of a solid, as if its file had arrived now.
fn quoted_row(
    profile: &MachineProfile,
    asked: &FileTerms,
    (id, file): (PartId, &QuotedFile),
    (object_index, solid): (u32, &PartFileSolid),
    now: Timestamp,
) -> PartRow {
    let [x, y, z] = solid.mesh.bounds().size().to_array();
    let terms = PartTerms {
        order_name: String::new(),
        customer: String::new(),
        email: String::new(),
        material: profile.materials.name_of(file.ticket.material.as_deref().unwrap_or_default()),
        finish: String::new(),
        priority: file.ticket.priority.unwrap_or(USUAL_PRIORITY),
        due_at: None,
        due_text: String::new(),
        orientation: asked.limits.rule,
        tilts: RequiredTilts(asked.limits.tilts.clone()),
        clearance_mm: file.ticket.clearance_mm,
        unit: asked.unit,
        note: String::new(),
        reference: String::new(),
    };
    let request = solid.request.as_deref().and_then(|request| requested_terms(request, profile).ok());
    PartRow {
        id,
        machine: profile.name.clone(),
        name: file.name.clone(),
        solid: SolidOfFile { object_index, object_name: solid.name.clone() },
        file: ClaimedFile { claim: String::new(), content_hash: String::new(), bytes: 0, reads: 0 },
        state: PartState::Waiting,
        refused: PartRefusal { reason: String::new(), refusal: None },
        warnings: String::new(),
        owed: OwedCopies {
            copies: solid.copies.saturating_mul(asked.copies),
            cancelled_copies: 0,
            put_back_at: None,
            fetch_at: None,
            question: String::new(),
            size_differs: false,
            replaced_by: None,
            awaits_material: false,
        },
        terms: match &request {
            Some(request) => terms.with_request(request),
            None => terms,
        },
        measures: PartMeasures {
            triangles: Some(solid.mesh.triangles().len() as u64),
            volume_mm3: Some(solid.mesh.volume_mm3()),
            size_x_mm: Some(x),
            size_y_mm: Some(y),
            size_z_mm: Some(z),
            read_unit: Some(profile.intake.unit),
        },
        mending: PartMending::default(),
        times: PartTimes { claimed_at: now.into(), waits_since: None, state_at: now.into(), damaged_at: None },
    }
}
