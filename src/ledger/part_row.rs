//! A part as its row says, and what is recorded of one.

use build_file::Unit;
use jiff::Timestamp;
use nester::{Orientation, OrientationRule, Tilt, TiltError, write_tilts};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sqlx::FromRow;

use super::{
    PartId, PartState, Refusal, Utc,
    word::{Word, own_word},
};

/// A claimed file, before it is read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NewPart {
    /// Name of the claim, unique per dropped file; recording it twice gives the same part.
    pub claim: String,
    /// Machine profile.
    pub profile: String,
    /// File name as dropped, escaped for display.
    pub name: String,
    /// BLAKE3 of the file, 64 hex digits.
    pub content_hash: String,
    /// Size of the file.
    pub bytes: u64,
    /// Copies that were asked, at least 1.
    pub copies: u32,
    /// What was asked beside the copies.
    #[serde(flatten)]
    pub terms: NewTerms,
    /// What was odd, one sentence each.
    pub warnings: Vec<String>,
    /// The ticket as received.
    pub ticket: Option<NewTicket>,
}

/// What was asked of a claimed file, beside the copies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NewTerms {
    /// Order or kit, "" = none.
    pub order_name: String,
    /// 0 to 100; 100 must be in the next build.
    pub priority: u8,
    /// When it is due.
    pub due_at: Option<Timestamp>,
    /// How it may be turned.
    pub orientation: OrientationRule,
    /// Which ways up it may stand.
    pub tilts: Tilts,
    /// Its own clearance, mm; `None` = the profile's.
    pub clearance_mm: Option<f64>,
    /// Unit that the ticket says; `None` = by the file or the profile.
    pub unit: Option<Unit>,
    /// Free text of the ticket.
    pub note: String,
}

/// Directions of a part's mesh that must stand near to straight up, all of them; in SQL a line of text.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Tilts(pub Vec<Tilt>);

impl TryFrom<String> for Tilts {
    type Error = TiltError;

    fn try_from(text: String) -> Result<Self, TiltError> {
        Tilt::parse_list(&text).map(Self)
    }
}

impl std::fmt::Display for Tilts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&write_tilts(&self.0))
    }
}

/// A ticket as received.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct NewTicket {
    /// What kind of ticket.
    pub source: TicketSource,
    /// Where it stood.
    pub file_name: String,
    /// Its text.
    pub text: String,
}

/// Where a ticket comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TicketSource {
    /// Copies in the file name.
    Name,
    /// A sidecar file of the part.
    Sidecar,
    /// A line of an order list.
    OrderList,
}

own_word!(TicketSource);

/// Answer to recording a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Recorded {
    /// The part.
    pub id: PartId,
    /// Whether the claim was new; `false` = it had been recorded before.
    pub fresh: bool,
}

/// What reading found out about one solid of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidFacts {
    /// Which solid of the file, from 0; 0 is the claimed row itself.
    pub object_index: u32,
    /// Name of the solid inside a 3MF, "" otherwise.
    pub object_name: String,
    /// Copies of this solid in all: those asked times the build items of the file. Kept as they are when the part was
    /// read before (a retry).
    pub copies: u32,
    /// Triangles.
    pub triangles: u64,
    /// Volume, mm3.
    pub volume_mm3: f64,
    /// Bounds as dropped, mm.
    pub size_mm: [f64; 3],
    /// What was odd, one sentence each; added to those of the claim.
    pub warnings: Vec<String>,
}

/// A part: one solid of one dropped file, for one machine profile, with its copies.
#[derive(Debug, Clone, PartialEq, Serialize, FromRow)]
pub struct PartRow {
    /// Its number.
    pub id: PartId,
    /// Machine profile.
    pub profile: String,
    /// File name as dropped, escaped for display.
    pub name: String,
    /// Which solid of the file it is.
    #[serde(flatten)]
    #[sqlx(flatten)]
    pub solid: SolidOfFile,
    /// The file itself.
    #[serde(flatten)]
    #[sqlx(flatten)]
    pub file: ClaimedFile,
    /// Where it stands.
    pub state: PartState,
    /// Why it was rejected, "" otherwise.
    pub reason: String,
    /// Why it is refused; `None` = it is not, or was before words for it were kept.
    pub refusal: Option<Refusal>,
    /// What was odd, one per line.
    pub warnings: String,
    /// Copies in all.
    pub copies: u32,
    /// What was asked beside the copies.
    #[serde(flatten)]
    #[sqlx(flatten)]
    pub terms: PartTerms,
    /// What was measured of it.
    #[serde(flatten)]
    #[sqlx(flatten)]
    pub measures: PartMeasures,
    /// When it was where in its life.
    #[serde(flatten)]
    #[sqlx(flatten)]
    pub times: PartTimes,
}

/// Which solid of a file a part is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema, FromRow)]
pub struct SolidOfFile {
    /// Which solid of the file, from 0.
    pub object_index: u32,
    /// Name of the solid inside a 3MF.
    pub object_name: String,
}

/// The file of a part as it was claimed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, FromRow)]
pub struct ClaimedFile {
    /// Name of the claim, unique per dropped file.
    pub claim: String,
    /// BLAKE3 of the file, 64 hex digits.
    pub content_hash: String,
    /// Size of the file.
    pub bytes: u64,
    /// How often reading it was begun.
    pub reads: u32,
}

/// What was asked of a part, beside the copies.
#[derive(Debug, Clone, PartialEq, Serialize, FromRow)]
pub struct PartTerms {
    /// Order or kit, "" = none.
    pub order_name: String,
    /// 0 to 100.
    pub priority: u8,
    /// When it is due.
    pub due_at: Option<Utc>,
    /// How it may be turned.
    #[sqlx(try_from = "Word<OrientationRule>")]
    pub orientation: OrientationRule,
    /// Which ways up it may stand.
    #[sqlx(try_from = "String")]
    pub tilts: Tilts,
    /// Its own clearance, mm; `None` = the profile's.
    pub clearance_mm: Option<f64>,
    /// Unit that the ticket said.
    #[sqlx(try_from = "Word<Option<Unit>>")]
    pub unit: Option<Unit>,
    /// Free text of the ticket.
    pub note: String,
}

/// What was measured of a part; `None` until read.
#[derive(Debug, Clone, PartialEq, Serialize, FromRow)]
pub struct PartMeasures {
    /// Triangles.
    pub triangles: Option<u64>,
    /// Volume, mm3.
    pub volume_mm3: Option<f64>,
    /// Width as dropped, mm.
    pub size_x_mm: Option<f64>,
    /// Depth as dropped, mm.
    pub size_y_mm: Option<f64>,
    /// Height as dropped, mm.
    pub size_z_mm: Option<f64>,
}

/// When a part was where in its life.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, FromRow)]
pub struct PartTimes {
    /// When it was claimed: its age in line.
    pub claimed_at: Utc,
    /// When its state was entered.
    pub state_at: Utc,
    /// When its stored file was found damaged; it waits for the same file to be dropped again.
    pub damaged_at: Option<Utc>,
}

impl PartRow {
    /// Whether nobody knows how many copies were meant: it is printed only when it is dropped again.
    pub fn has_unknown_copies(&self) -> bool {
        self.refusal == Some(Refusal::Ticket)
    }
}

impl PartRow {
    /// Name of the part with that of its solid.
    pub fn full_name(&self) -> String {
        match self.solid.object_name.as_str() {
            "" => self.name.clone(),
            // A file of one solid often gives it its own name.
            object if self.name.rsplit_once('.').is_some_and(|(stem, _)| stem == object) => self.name.clone(),
            object => format!("{} ({object})", self.name),
        }
    }

    /// How it may be turned, whole.
    pub fn turning(&self) -> Orientation {
        Orientation { rule: self.terms.orientation, tilts: self.terms.tilts.0.clone() }
    }

    /// Bounds as dropped, mm; `None` until read.
    pub fn size_mm(&self) -> Option<[f64; 3]> {
        Some([self.measures.size_x_mm?, self.measures.size_y_mm?, self.measures.size_z_mm?])
    }
}
