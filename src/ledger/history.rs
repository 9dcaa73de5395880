//! The history: builds with their heights, newest first.

use std::collections::HashSet;

use jiff::Timestamp;
use serde::Serialize;
use sqlx::FromRow;

use super::{BuildId, BuildState, Ledger, Utc, error::Result};
use crate::format::cell;

/// Which builds to list. A build's time is when it was published, else when it entered its state.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct HistoryQuery {
    /// Not before.
    pub since: Option<Timestamp>,
    /// Before.
    pub until: Option<Timestamp>,
    /// Of one machine profile only.
    pub profile: Option<String>,
    /// So many at most; `None` = all.
    pub limit: Option<u32>,
}

/// A build that is past nesting.
#[derive(Debug, Clone, PartialEq, Serialize, FromRow)]
pub struct HistoryRow {
    /// Its number.
    pub build: BuildId,
    /// Machine profile.
    pub profile: String,
    /// Where it stands.
    pub state: BuildState,
    /// When it was published, else when it entered its state.
    pub at: Utc,
    /// When it came into the queue; `None` = never.
    pub published_at: Option<Utc>,
    /// Build height, mm.
    pub height_mm: Option<f64>,
    /// Part volume / (base area x height), 0..1.
    pub density: Option<f64>,
    /// No build of these parts can be lower, mm.
    pub lower_bound_mm: Option<f64>,
    /// Layers to print.
    pub layers: Option<u32>,
    /// Distinct parts.
    pub parts: u32,
    /// Placements.
    pub copies: Option<u32>,
    /// Volume of all parts in it, mm3.
    pub part_volume_mm3: Option<f64>,
    /// Clearance asked, mm.
    pub clearance_mm: Option<f64>,
    /// Least distance found on the triangles of the written file, mm.
    pub clearance_proved_mm: Option<f64>,
    /// CPU seconds of all nesting for it.
    pub cpu_secs: Option<f64>,
    /// Wall seconds of the final nesting.
    pub wall_secs: Option<f64>,
    /// Evaluations of the final nesting.
    pub evaluations: Option<u64>,
    /// Seed of the final nesting, its bits as a signed number.
    pub seed: Option<i64>,
    /// nestd or paper.
    pub method: Option<String>,
    /// Version of nestd.
    pub version: Option<String>,
    /// Trigger.
    pub fired_by: String,
    /// Name of the build file.
    pub file_name: Option<String>,
    /// Why it failed, or the outcome's note.
    pub reason: String,
    /// The note of the outcome that was told last, "" when there is none.
    pub note: String,
}

/// What a row of the history is made of.
const COLUMNS: &str = "b.id AS build, b.profile, b.state, coalesce(b.published_at, b.state_at) AS at, b.published_at, \
    b.height_mm, b.density, b.lower_bound_mm, b.layers, \
    (SELECT count(DISTINCT l.part_id) FROM placement l WHERE l.build_id = b.id) AS parts, b.copies, \
    b.part_volume_mm3, b.clearance_mm, b.clearance_proved_mm, b.cpu_secs, b.wall_secs, b.evaluations, \
    b.seed, b.method, b.version, b.fired_by, b.file_name, b.reason, \
    coalesce((SELECT o.note FROM outcome o WHERE o.build_id = b.id ORDER BY o.id DESC LIMIT 1), '') AS note";
impl HistoryRow {
    /// Columns of the CSV, in its order.
    pub const COLUMNS: [&str; 24] = [
        "build",
        "profile",
        "state",
        "at",
        "published_at",
        "height_mm",
        "density",
        "lower_bound_mm",
        "layers",
        "parts",
        "copies",
        "part_volume_mm3",
        "clearance_mm",
        "clearance_proved_mm",
        "cpu_secs",
        "wall_secs",
        "evaluations",
        "seed",
        "method",
        "version",
        "fired_by",
        "file_name",
        "reason",
        "note",
    ];

    /// The row with texts that are no formulas; numbers stay numbers.
    fn as_cells(&self) -> Self {
        let some = |text: &Option<String>| text.as_deref().map(cell);
        Self {
            profile: cell(&self.profile),
            method: some(&self.method),
            version: some(&self.version),
            fired_by: cell(&self.fired_by),
            file_name: some(&self.file_name),
            reason: cell(&self.reason),
            note: cell(&self.note),
            ..self.clone()
        }
    }

    /// Rows as CSV for spreadsheets, every column, with a heading.
    ///
    /// # Errors
    /// When a value cannot be written as a cell, which none of them is.
    pub fn csv(rows: &[Self]) -> std::result::Result<String, csv::Error> {
        let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
        writer.write_record(Self::COLUMNS)?;
        for row in rows {
            writer.serialize(row.as_cells())?;
        }
        let bytes = writer.into_inner().map_err(|error| error.into_error())?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }
}

impl Ledger {
    /// The builds that hold a copy of a part of that file name or order.
    pub async fn builds_with(&self, name: &str) -> Result<HashSet<BuildId>> {
        let query = sqlx::query_scalar(
            "SELECT l.build_id FROM part p CROSS JOIN placement l ON l.part_id = p.id WHERE p.name = ?1 \
             UNION SELECT l.build_id FROM part p CROSS JOIN placement l ON l.part_id = p.id \
             WHERE p.order_name = ?1 AND p.order_name <> ''",
        );
        Ok(query.bind(name).fetch_all(self.reader()).await?.into_iter().collect())
    }

    /// Builds that are past nesting with their heights, newest first.
    pub async fn history(&self, query: &HistoryQuery) -> Result<Vec<HistoryRow>> {
        let rows = sqlx::query_as(sqlx::AssertSqlSafe(sql(query.profile.is_some())))
            .bind(query.since.map(Utc))
            .bind(query.until.map(Utc))
            .bind(query.limit.map_or(-1, i64::from))
            .bind(&query.profile);
        Ok(rows.fetch_all(self.reader()).await?)
    }
}

/// The question; each of its forms walks an index of its own from the newest build on. Times are text that begins with a
/// digit, so that '' is before all of them and ':' after.
pub(super) fn sql(of_one_profile: bool) -> String {
    let of_profile = if of_one_profile { "b.profile = ?4 AND" } else { "" };
    format!(
        "SELECT {COLUMNS} FROM build b WHERE {of_profile} b.state NOT IN ('open', 'nesting') \
         AND coalesce(b.published_at, b.state_at) >= coalesce(?1, '') \
         AND coalesce(b.published_at, b.state_at) < coalesce(?2, ':') \
         ORDER BY coalesce(b.published_at, b.state_at) DESC, b.id DESC LIMIT ?3"
    )
}
