//! Totals over everything that ever was, for metrics.

use sqlx::FromRow;

use super::{Ledger, error::Result};

/// What was ever taken and built.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Totals {
    /// Profile, state, parts in it.
    pub parts: Vec<(String, String, u64)>,
    /// Profile, files that were taken.
    pub files: Vec<(String, u64)>,
    /// Profile, word of [`super::Refusal`] or "", files that were refused; with parts that were cancelled.
    pub refused: Vec<(String, String, u64)>,
    /// Profile, written builds that could not be proved.
    pub unproved: Vec<(String, u64)>,
    /// Builds by profile, state and whether they were published.
    pub builds: Vec<BuildCount>,
    /// What was measured of every published build.
    pub measured: Vec<Measured>,
}

/// How many builds of a profile are in a state.
#[derive(Debug, Clone, PartialEq, Eq, FromRow)]
pub struct BuildCount {
    /// Machine profile.
    pub profile: String,
    /// Where they stand.
    pub state: String,
    /// Whether they were published.
    pub is_published: bool,
    /// How many.
    pub builds: u64,
}

/// What was measured of a published build.
#[derive(Debug, Clone, PartialEq, FromRow)]
pub struct Measured {
    /// Machine profile.
    pub profile: String,
    /// Build height, mm.
    pub height_mm: Option<f64>,
    /// Density, 0..1.
    pub density: Option<f64>,
    /// Wall seconds of the final nesting.
    pub wall_secs: Option<f64>,
}

const PARTS: &str = "SELECT profile, state, count(*) FROM part GROUP BY profile, state ORDER BY profile, state";
const FILES: &str = "SELECT profile, count(*) FROM part WHERE object_index = 0 GROUP BY profile ORDER BY profile";
/// The solids of a file are refused together: the first speaks for them. What was refused before it was a part has none.
const REFUSED: &str = "SELECT e.profile, e.cause, count(*) FROM event e LEFT JOIN part p ON p.id = e.part_id \
    WHERE e.kind IN ('rejected', 'refused', 'proof_failed') AND e.kind <> 'proof_failed' \
    AND coalesce(p.object_index, 0) = 0 GROUP BY e.profile, e.cause ORDER BY e.profile, e.cause";
const UNPROVED: &str = "SELECT profile, count(*) FROM event WHERE kind IN ('rejected', 'refused', 'proof_failed') \
    AND kind = 'proof_failed' GROUP BY profile ORDER BY profile";
const BUILDS: &str = "SELECT profile, state, published_at IS NOT NULL AS is_published, count(*) AS builds FROM build \
    GROUP BY profile, state, is_published ORDER BY profile, state, is_published";
const MEASURED: &str = "SELECT profile, height_mm, density, wall_secs FROM build WHERE published_at IS NOT NULL";

impl Ledger {
    /// Counts of everything, as of one moment.
    pub async fn totals(&self) -> Result<Totals> {
        let mut snapshot = self.snapshot().await?;
        let db = &mut *snapshot;
        Ok(Totals {
            parts: sqlx::query_as(PARTS).fetch_all(&mut *db).await?,
            files: sqlx::query_as(FILES).fetch_all(&mut *db).await?,
            refused: sqlx::query_as(REFUSED).fetch_all(&mut *db).await?,
            unproved: sqlx::query_as(UNPROVED).fetch_all(&mut *db).await?,
            builds: sqlx::query_as(BUILDS).fetch_all(&mut *db).await?,
            measured: sqlx::query_as(MEASURED).fetch_all(&mut *db).await?,
        })
    }
}
