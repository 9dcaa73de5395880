//! The row of a part, and the data recorded for a new one.
//!
//! A new column of it is added in `migrations/` and `migrations/postgres/` (named in `store/schema` and `store/postgres/schema`), here, and, if
//! it is asked with a part, in `parts/claim`, `parts/edit`, `keep/decisions` (a ticket that is read again) and `keep/record_rows` (the archive).

use build_file::LengthUnit;
use jiff::Timestamp;
use nester::{OrientationLimits, OrientationRule, TiltLimit, TiltLimitError, write_tilts};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    PartId, PartMeasures, PartMending, PartState, PartTimes, RefusalCause, UtcTimestamp,
    base::{
        sql::{bind_as_text, read_text_by, sql_row},
        text_column::own_word,
    },
};

/// The row for a claimed file that has not been read yet.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NewPartRow {
    /// Name of the claim, unique per dropped file. Recording it twice returns the same part.
    pub claim: String,
    /// Machine. Notes of claims call it `profile` where an earlier version wrote them.
    #[serde(alias = "profile")]
    pub machine: String,
    /// File name as dropped, escaped for display.
    pub name: String,
    /// BLAKE3 of the file, 64 hex digits.
    pub content_hash: String,
    /// Size of the file.
    pub bytes: u64,
    /// Ordered copies, at least 1.
    pub copies: u32,
    /// Requested terms other than the copies.
    #[serde(flatten)]
    pub terms: NewTerms,
    /// Warnings, one sentence each.
    pub warnings: Vec<String>,
    /// The ticket as received.
    pub ticket: Option<NewTicketRow>,
    /// The file as it lay in the hot folder.
    #[serde(flatten)]
    pub dropped: DroppedFile,
}

/// A file as it lay in a hot folder.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct DroppedFile {
    /// Folders between the hot folder and the file, escaped for display and joined by `/`. Empty = none.
    pub folder: String,
    /// Its modification time, nanoseconds since 1970; `None` = it did not come through a folder, or that is not known.
    pub mtime_ns: Option<i64>,
    /// The claim of what was taken of this file before its writer went on.
    pub rewrites: Option<String>,
}

/// The columns of what was asked with a part, as one solid of a file takes them from another, and a revision from the part that it replaces.
macro_rules! term_columns {
    () => {
        "customer, email, material, material_key, finish, priority, due_at, due_text, orientation, tilts, clearance_mm, unit, note"
    };
}
pub(crate) use term_columns;

/// Requested terms for a claimed file, other than the copies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NewTerms {
    /// Order or kit, "" = none.
    pub order_name: String,
    /// Who it is for, "" = not said.
    #[serde(default)]
    pub customer: String,
    /// Where that customer gets e-mail, "" = not said.
    #[serde(default)]
    pub email: String,
    /// What it is to be made of, "" = anything.
    #[serde(default)]
    pub material: String,
    /// Finishing steps after the print, as `build_file::finish_steps` reads them, "" = none.
    #[serde(default)]
    pub finish: String,
    /// Priority from 0 to 100. A part with 100 must be in the next build.
    pub priority: u8,
    /// When it is due.
    pub due_at: Option<Timestamp>,
    /// The due date as it was given, "" = none.
    #[serde(default)]
    pub due_text: String,
    /// Orientation rule.
    pub orientation: OrientationRule,
    /// Directions that must point nearly straight up.
    pub tilts: RequiredTilts,
    /// Its own clearance, mm; `None` = the machine's.
    pub clearance_mm: Option<f64>,
    /// Unit from the ticket; `None` = that of the file or the machine.
    pub unit: Option<LengthUnit>,
    /// Unit of a file that states none: its machine's when it was claimed.
    #[serde(default)]
    pub read_unit: Option<LengthUnit>,
    /// Free text of the ticket.
    pub note: String,
    /// Who said that its mesh may be mended where it is not closed, "" = nobody.
    #[serde(default)]
    pub mend_allowed_by: String,
}

/// Directions of the part's mesh that must point nearly straight up; all of them apply. Stored in SQL as one line of text.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct RequiredTilts(pub Vec<TiltLimit>);

bind_as_text!(RequiredTilts);
read_text_by!(RequiredTilts, |text: &str| RequiredTilts::try_from(text.to_owned()));

impl TryFrom<String> for RequiredTilts {
    type Error = TiltLimitError;

    fn try_from(text: String) -> Result<Self, TiltLimitError> {
        TiltLimit::parse_list(&text).map(Self)
    }
}

impl std::fmt::Display for RequiredTilts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&write_tilts(&self.0))
    }
}

/// A ticket as received.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct NewTicketRow {
    /// Kind of source.
    pub source: TicketSource,
    /// File that contained it.
    pub file_name: String,
    /// Its text.
    pub text: String,
}

/// Source of a ticket.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TicketSource {
    /// Copies in the file name.
    Name,
    /// A sidecar file of the part.
    Sidecar,
    /// A row of an order list.
    OrderList,
}

own_word!(TicketSource);

/// A part: one solid of one dropped file, for one machine, with its copies.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PartRow {
    /// Its number.
    pub id: PartId,
    /// Machine.
    pub machine: String,
    /// File name as dropped, escaped for display.
    pub name: String,
    /// Which solid of the file it is.
    #[serde(flatten)]
    pub solid: SolidOfFile,
    /// The file itself.
    #[serde(flatten)]
    pub file: ClaimedFile,
    /// Current state.
    pub state: PartState,
    /// Why it was refused, if it was.
    #[serde(flatten)]
    pub refused: PartRefusal,
    /// Warnings, one per line.
    pub warnings: String,
    /// Its copies, and what the part waits for.
    #[serde(flatten)]
    pub owed: OwedCopies,
    /// Requested terms other than the copies.
    #[serde(flatten)]
    pub terms: PartTerms,
    /// Its measurements.
    #[serde(flatten)]
    pub measures: PartMeasures,
    /// Whether its mesh may be mended, and was.
    #[serde(flatten)]
    pub mending: PartMending,
    /// Times of its states.
    #[serde(flatten)]
    pub times: PartTimes,
}

sql_row!(PartRow { id, machine, name, state, warnings; solid, file, refused, owed, terms, measures, mending, times });

/// Which solid of a file a part is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct SolidOfFile {
    /// Index of the solid in the file, from 0.
    pub object_index: u32,
    /// Name of the solid inside a 3MF.
    pub object_name: String,
}

sql_row!(SolidOfFile { object_index, object_name });

/// The file of a part as it was claimed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ClaimedFile {
    /// Name of the claim, unique per dropped file.
    pub claim: String,
    /// BLAKE3 of the file, 64 hex digits.
    pub content_hash: String,
    /// Size of the file.
    pub bytes: u64,
    /// Number of times that reading it was started.
    pub reads: u32,
}

sql_row!(ClaimedFile { claim, content_hash, bytes, reads });

/// Why a part was refused.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PartRefusal {
    /// The reason in words, "" if it was not refused.
    pub reason: String,
    /// The cause; `None` = it was not refused, or it was refused before causes were recorded.
    pub refusal: Option<RefusalCause>,
}

sql_row!(PartRefusal { reason, refusal });

/// The copies of a part, and what it waits for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct OwedCopies {
    /// Copies ever wanted. Copy numbers are below this.
    pub copies: u32,
    /// How many copies are not wanted any more.
    pub cancelled_copies: u32,
    /// When copies that were printed badly were first put back among the waiting ones since it was last built. They go first.
    pub put_back_at: Option<UtcTimestamp>,
    /// When its original was requested from the archive. The part waits until the store has it.
    pub fetch_at: Option<UtcTimestamp>,
    /// What a person must confirm before it is printed, "" = nothing.
    pub question: String,
    /// Whether that is its size: its file was read in another one than the first time.
    pub size_differs: bool,
    /// The newer revision that replaced it.
    pub replaced_by: Option<PartId>,
    /// Whether it waits for its material: its machine has another one loaded, or none.
    pub awaits_material: bool,
}

impl OwedCopies {
    /// Whether the part waits for its original to come from the archive or from another node.
    pub fn is_being_fetched(&self) -> bool {
        self.fetch_at.is_some()
    }
}

sql_row!(OwedCopies {
    copies,
    cancelled_copies,
    put_back_at,
    fetch_at,
    question,
    size_differs,
    replaced_by,
    awaits_material
});

/// Requested terms for a part, other than the copies.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PartTerms {
    /// Order or kit, "" = none.
    pub order_name: String,
    /// Who it is for, "" = not said.
    pub customer: String,
    /// Where that customer gets e-mail, "" = not said.
    pub email: String,
    /// What it is to be made of, "" = anything.
    pub material: String,
    /// Finishing steps after the print, as `build_file::finish_steps` reads them, "" = none.
    pub finish: String,
    /// Priority from 0 to 100.
    pub priority: u8,
    /// When it is due.
    pub due_at: Option<UtcTimestamp>,
    /// The due date as it was given, "" = none.
    pub due_text: String,
    /// Orientation rule.
    pub orientation: OrientationRule,
    /// Directions that must point nearly straight up.
    pub tilts: RequiredTilts,
    /// Its own clearance, mm; `None` = the machine's.
    pub clearance_mm: Option<f64>,
    /// Unit from the ticket.
    pub unit: Option<LengthUnit>,
    /// Free text of the ticket.
    pub note: String,
    /// What the customer's own system calls the line, "" = not said.
    pub reference: String,
}

sql_row!(PartTerms {
    order_name,
    customer,
    email,
    material,
    finish,
    priority,
    due_at,
    due_text,
    orientation,
    tilts,
    clearance_mm,
    unit,
    note,
    reference
});

/// Name of a file together with the name of its solid.
pub(crate) fn name_with_solid(name: &str, solid: &str) -> String {
    match solid {
        "" => name.to_owned(),
        // In a file with one solid, the solid often has the name of the file.
        _ if name.rsplit_once('.').is_some_and(|(stem, _)| stem == solid) => name.to_owned(),
        _ => format!("{name} ({solid})"),
    }
}

/// Begin of the claims of files that never came: there is no such file anywhere.
const MISSING_CLAIM: &str = "row-";

/// The claim of a file that a row names and that never came. `list_and_file` = key of the list and of the name of the file, with one `-`
/// before that; `asked` = the order and what the row says.
pub fn missing_file_claim(list_and_file: &str, asked: &str) -> String {
    format!("{MISSING_CLAIM}{list_and_file}-{}", &blake3::hash(asked.as_bytes()).to_hex()[..16])
}

/// Whether a claim is that of a file that never came.
pub fn is_missing_file(claim: &str) -> bool {
    claim.starts_with(MISSING_CLAIM)
}

impl PartRow {
    /// Whether the requested number of copies is unknown. Such a part is printed only if it is dropped again.
    pub fn has_unknown_copies(&self) -> bool {
        self.refused.refusal == Some(RefusalCause::Ticket)
    }

    /// Whether it was refused and its file can be read once more as it is.
    pub fn can_be_read_again(&self) -> bool {
        self.state == PartState::Refused && !self.has_unknown_copies() && !is_missing_file(&self.file.claim)
    }

    /// When it arrived among the waiting parts: it was read, taken back, moved or left out, copies
    /// of it were put back, or a person confirmed it or dropped its original again.
    pub fn arrived_at(&self) -> UtcTimestamp {
        self.owed.put_back_at.unwrap_or(self.times.state_at).max(self.times.state_at)
    }

    /// Since when copies of it wait for a build: what `max_wait_secs` and `at` count from.
    pub fn waits_since(&self) -> UtcTimestamp {
        self.times.waits_since.unwrap_or(self.times.claimed_at)
    }

    /// Copies wanted: those ever wanted without the cancelled ones.
    pub fn wanted_copies(&self) -> u32 {
        self.owed.copies.saturating_sub(self.owed.cancelled_copies)
    }

    /// Name of the part together with the name of its solid.
    pub fn full_name(&self) -> String {
        name_with_solid(&self.name, &self.solid.object_name)
    }

    /// The complete orientation rules: rule and tilts.
    pub fn orientation_limits(&self) -> OrientationLimits {
        OrientationLimits { rule: self.terms.orientation, tilts: self.terms.tilts.0.clone() }
    }

    /// Bounds as dropped, mm; `None` until read.
    pub fn size_mm(&self) -> Option<[f64; 3]> {
        Some([self.measures.size_x_mm?, self.measures.size_y_mm?, self.measures.size_z_mm?])
    }
}
