//! Builds: the parts of a profile taken together, one build file, one height.

use serde::Serialize;
use sqlx::FromRow;

use super::{BuildId, BuildState, Ledger, Utc, error::Result};

/// Points of a curve that are kept.
const MOST_POINTS: usize = 300;

/// A build. Of an open build height, density and copies are those of its layout so far.
#[derive(Debug, Clone, PartialEq, Serialize, FromRow)]
pub struct BuildRow {
    /// Its number.
    pub id: BuildId,
    /// Machine profile.
    pub profile: String,
    /// Where it stands.
    pub state: BuildState,
    /// Why it failed, or the outcome's note.
    pub reason: String,
    /// Trigger: full, fill, copies, max_wait, due, at, flush.
    pub fired_by: String,
    /// How often nesting was begun.
    pub attempts: u32,
    /// How often a search was begun since one came to its end.
    pub searches: u32,
    /// When it was opened.
    pub opened_at: Utc,
    /// When it fired.
    pub nesting_at: Option<Utc>,
    /// When its file was proved.
    pub verified_at: Option<Utc>,
    /// When the first rename that publishes it was about to be tried.
    pub publishing_at: Option<Utc>,
    /// When it came into the queue.
    pub published_at: Option<Utc>,
    /// When its state was entered.
    pub state_at: Utc,
    /// JSON, the best layout so far while open or nesting; too long for a person, so that faces leave it out.
    #[serde(skip)]
    pub layout: Option<String>,
    /// Name of the build file in the queue folder.
    pub file_name: Option<String>,
    /// Which queue folder it was staged in (its marker).
    pub queue_id: Option<String>,
    /// BLAKE3 of the build file, 64 hex digits.
    pub file_hash: Option<String>,
    /// Size of the build file.
    pub file_bytes: Option<u64>,
    /// Build height, mm.
    pub height_mm: Option<f64>,
    /// Part volume / (base area x height), 0..1.
    pub density: Option<f64>,
    /// No build of these parts can be lower, mm.
    pub lower_bound_mm: Option<f64>,
    /// Layers to print.
    pub layers: Option<u32>,
    /// Volume of all parts in it, mm3.
    pub part_volume_mm3: Option<f64>,
    /// Placements.
    pub copies: Option<u32>,
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
    /// JSON, the profile as it was.
    pub profile_snapshot: Option<String>,
    /// JSON, how the height fell: see [`BuildRow::curve`]; faces leave it out as they do with the layout.
    #[serde(skip)]
    pub curve: Option<String>,
    /// JSON, what is staged beside the build file: see [`BuildRow::sidecars`].
    #[serde(skip)]
    pub sidecars: Option<String>,
}

impl BuildRow {
    /// How the height fell: (wall seconds, build height in mm) of the search's improvements; empty until verified.
    pub fn curve(&self) -> Vec<(f64, f64)> {
        self.curve.as_deref().and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default()
    }

    /// Name and BLAKE3 of each file that is staged beside the build file; empty where that is not known.
    pub fn sidecars(&self) -> Vec<(String, String)> {
        self.sidecars.as_deref().and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default()
    }
}

/// The layout of an open build as it is kept.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenLayout {
    /// JSON, the layout itself.
    pub layout: String,
    /// Its height, mm.
    pub height_mm: f64,
    /// Its density, 0..1.
    pub density: f64,
    /// Copies placed in it.
    pub copies: u32,
    /// Volume of the placed parts, mm3.
    pub part_volume_mm3: f64,
}

/// What is known of a build whose file is written and proved.
#[derive(Debug, Clone, PartialEq)]
pub struct Verified {
    /// Name of the build file in the queue folder.
    pub file_name: String,
    /// Marker of the queue folder that it is staged in.
    pub queue_id: String,
    /// BLAKE3 of the build file, 64 hex digits.
    pub file_hash: String,
    /// Size of the build file.
    pub file_bytes: u64,
    /// Name and BLAKE3 of each file that is staged beside it.
    pub sidecars: Vec<(String, String)>,
    /// Build height, mm.
    pub height_mm: f64,
    /// Part volume / (base area x height), 0..1.
    pub density: f64,
    /// No build of these parts can be lower, mm.
    pub lower_bound_mm: f64,
    /// Layers to print.
    pub layers: u32,
    /// Volume of all parts in it, mm3.
    pub part_volume_mm3: f64,
    /// Placements.
    pub copies: u32,
    /// Clearance asked, mm.
    pub clearance_mm: f64,
    /// Least distance found on the triangles of the written file, mm; `None` = a single copy has no neighbour.
    pub clearance_proved_mm: Option<f64>,
    /// CPU seconds of the final nesting; they are added to those of [`super::Ledger::add_cpu_secs`].
    pub cpu_secs: f64,
    /// Wall seconds of the final nesting.
    pub wall_secs: f64,
    /// Evaluations of the final nesting.
    pub evaluations: u64,
    /// Seed of the final nesting.
    pub seed: u64,
    /// nestd or paper.
    pub method: String,
    /// Version of nestd.
    pub version: String,
    /// JSON, the profile as it was.
    pub profile_snapshot: String,
    /// How the height fell: (wall seconds, build height in mm) of every improvement.
    pub curve: Vec<(f64, f64)>,
}

impl Verified {
    /// The curve as the ledger keeps it, of a few hundred points at most, the last one always.
    pub(super) fn curve_json(&self) -> String {
        let step = self.curve.len().div_ceil(MOST_POINTS).max(1);
        let kept = self.curve.iter().rev().step_by(step);
        let rounded = |&(secs, mm): &(f64, f64)| ((1e3 * secs).round() / 1e3, (1e4 * mm).round() / 1e4);
        let mut points: Vec<(f64, f64)> = kept.map(rounded).collect();
        points.reverse();
        serde_json::to_string(&points).unwrap_or_default()
    }
}

impl Ledger {
    /// The open build of a profile; opened when there is none.
    pub async fn open_build(&self, profile: &str) -> Result<BuildRow> {
        let open = "SELECT * FROM build WHERE profile = ? AND state = 'open'";
        if let Some(build) = sqlx::query_as(open).bind(profile).fetch_optional(self.reader()?).await? {
            return Ok(build);
        }
        let mut change = self.change().await?;
        let now = change.now;
        sqlx::query(
            "INSERT INTO build (profile, state, opened_at, state_at) VALUES (?, 'open', ?, ?) \
             ON CONFLICT (profile) WHERE state = 'open' DO NOTHING",
        )
        .bind(profile)
        .bind(now)
        .bind(now)
        .execute(change.db())
        .await?;
        let build = sqlx::query_as(open).bind(profile).fetch_one(change.db()).await?;
        change.commit().await?;
        Ok(build)
    }

    /// Deletes the open build of a profile that is no more; it holds no copy. What was told of it stays, without its
    /// number.
    pub async fn drop_open_build(&self, profile: &str) -> Result<()> {
        let mut change = self.change().await?;
        sqlx::query(
            "UPDATE event SET build_id = NULL WHERE build_id IN \
             (SELECT id FROM build WHERE profile = ? AND state = 'open')",
        )
        .bind(profile)
        .execute(change.db())
        .await?;
        let drop = sqlx::query("DELETE FROM build WHERE profile = ? AND state = 'open'").bind(profile);
        drop.execute(change.db()).await?;
        change.commit().await
    }

    /// Keeps the layout of an open or nesting build.
    pub async fn save_layout(&self, build: BuildId, layout: &OpenLayout) -> Result<()> {
        let mut change = self.change().await?;
        change.demand(build, &[BuildState::Open, BuildState::Nesting]).await?;
        sqlx::query(
            "UPDATE build SET layout = ?, height_mm = ?, density = ?, part_volume_mm3 = ?, \
             copies = CASE state WHEN 'open' THEN ? ELSE copies END WHERE id = ?",
        )
        .bind(&layout.layout)
        .bind(layout.height_mm)
        .bind(layout.density)
        .bind(layout.part_volume_mm3)
        .bind(layout.copies)
        .bind(build)
        .execute(change.db())
        .await?;
        change.commit().await
    }

    /// Adds CPU seconds of nesting for an open or nesting build.
    pub async fn add_cpu_secs(&self, build: BuildId, cpu_secs: f64) -> Result<()> {
        let mut change = self.change().await?;
        change.demand(build, &[BuildState::Open, BuildState::Nesting]).await?;
        let add = sqlx::query("UPDATE build SET cpu_secs = coalesce(cpu_secs, 0) + ? WHERE id = ?");
        add.bind(cpu_secs).bind(build).execute(change.db()).await?;
        change.commit().await
    }

    /// All builds in a state, oldest first.
    pub async fn builds_in_state(&self, state: BuildState) -> Result<Vec<BuildRow>> {
        let query = sqlx::query_as("SELECT * FROM build WHERE state = ? ORDER BY id").bind(state);
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// The build of a profile that was given up last, and why.
    pub async fn last_failure(&self, profile: &str) -> Result<Option<(BuildId, String)>> {
        let query = sqlx::query_as(
            "SELECT id, reason FROM build WHERE state = 'failed' AND profile = ? AND published_at IS NULL \
             ORDER BY id DESC LIMIT 1",
        );
        Ok(query.bind(profile).fetch_optional(self.reader()?).await?)
    }

    /// A build.
    pub async fn build(&self, id: BuildId) -> Result<Option<BuildRow>> {
        let query = sqlx::query_as("SELECT * FROM build WHERE id = ?").bind(id);
        Ok(query.fetch_optional(self.reader()?).await?)
    }
}
