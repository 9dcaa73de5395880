//! What was measured of a part, and the times of its states.

use build_file::LengthUnit;
use schemars::JsonSchema;
use serde::Serialize;

use crate::{UtcTimestamp, base::sql::sql_row};

/// Measurements of a part; `None` until read.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
    /// Unit in which its file is read again where that states none; also before it is read, where its claim knows it.
    pub read_unit: Option<LengthUnit>,
}

sql_row!(PartMeasures { triangles, volume_mm3, size_x_mm, size_y_mm, size_z_mm, read_unit });

/// Whether the mesh of a part may be mended, and what was done to it. From then on the mended mesh is the part's.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, JsonSchema)]
pub struct PartMending {
    /// Who said that its mesh may be mended: user@host, `ticket`, or `mesh_errors`, the setting of its machine. "" = nobody.
    pub mend_allowed_by: String,
    /// What was done to its mesh, in words with measures; "" = it is printed as it was dropped.
    pub mended: String,
    /// BLAKE3 of the mended mesh, 64 hex digits; "" = not mended.
    pub mended_hash: String,
}

sql_row!(PartMending { mend_allowed_by, mended, mended_hash });

/// The ticket of a part allows that its mesh is mended.
pub const MEND_BY_TICKET: &str = "ticket";
/// The setting of its machine allows it.
pub const MEND_BY_SETTING: &str = "mesh_errors";

/// Times of the states of a part.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PartTimes {
    /// When it was claimed. Determines who goes first among waiting parts.
    pub claimed_at: UtcTimestamp,
    /// Since when it waits, if it came back: copies were put back or more were wanted of what was built, or it was taken back. `None` =
    /// since it was claimed.
    pub waits_since: Option<UtcTimestamp>,
    /// When it entered its current state.
    pub state_at: UtcTimestamp,
    /// When its stored file was found damaged. It then waits for the same file to be dropped again.
    pub damaged_at: Option<UtcTimestamp>,
}

sql_row!(PartTimes { claimed_at, waits_since, state_at, damaged_at });
