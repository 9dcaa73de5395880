//! Totals since the ledger was created, for metrics.

use crate::{
    Ledger,
    base::{
        error::Result,
        sql::{self, sql_row},
    },
};

/// Totals of everything that was taken and built.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FarmTotals {
    /// Machine, state, number of parts.
    pub parts: Vec<(String, String, u64)>,
    /// Machine, number of claimed files.
    pub files: Vec<(String, u64)>,
    /// Machine, word of [`crate::RefusalCause`] or "", number of refused files. Includes cancelled parts.
    pub refused: Vec<(String, String, u64)>,
    /// Machine, number of written builds that could not be proved.
    pub unproved: Vec<(String, u64)>,
    /// Number of builds by machine, state and whether they were published.
    pub builds: Vec<BuildCount>,
    /// Measured values of every published build.
    pub measured: Vec<MeasuredBuild>,
}

/// Number of builds of a machine in a state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BuildCount {
    /// Machine.
    pub machine: String,
    /// Their state.
    pub state: String,
    /// Whether they were published.
    pub is_published: bool,
    /// Number of builds.
    pub builds: u64,
}

sql_row!(BuildCount { machine, state, is_published, builds });

/// Measured values of a published build.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredBuild {
    /// Machine.
    pub machine: String,
    /// Build height, mm.
    pub height_mm: Option<f64>,
    /// Density, 0..1.
    pub density: Option<f64>,
    /// Wall seconds of the final nesting.
    pub wall_secs: Option<f64>,
}

sql_row!(MeasuredBuild { machine, height_mm, density, wall_secs });

const PARTS: &str = "SELECT machine, state, count(*) FROM part GROUP BY machine, state ORDER BY machine, state";
const FILES: &str = "SELECT machine, count(*) FROM part WHERE object_index = 0 GROUP BY machine ORDER BY machine";
/// The solids of a file are refused together, so only the first is counted. A file that was refused before it became a
/// part has no part row.
const REFUSED: &str = "SELECT e.machine, e.cause, count(*) FROM event e LEFT JOIN part p ON p.id = e.part_id \
    WHERE e.kind IN ('refused', 'proof_failed') AND e.kind <> 'proof_failed' \
    AND coalesce(p.object_index, 0) = 0 GROUP BY e.machine, e.cause ORDER BY e.machine, e.cause";
const UNPROVED: &str = "SELECT machine, count(*) FROM event WHERE kind IN ('refused', 'proof_failed') \
    AND kind = 'proof_failed' GROUP BY machine ORDER BY machine";
const BUILDS: &str = "SELECT machine, CASE WHEN withdrawn_at IS NULL THEN state ELSE 'withdrawn' END AS state, \
    published_at IS NOT NULL AS is_published, count(*) AS builds FROM build GROUP BY 1, 2, 3 ORDER BY 1, 2, 3";
const MEASURED: &str = "SELECT machine, height_mm, density, wall_secs FROM build WHERE published_at IS NOT NULL";

impl Ledger {
    /// Reads all totals in one consistent snapshot.
    pub async fn read_totals(&self) -> Result<FarmTotals> {
        let mut snapshot = self.begin_snapshot().await?;
        let db = &mut snapshot;
        Ok(FarmTotals {
            parts: sql::query_as(PARTS).fetch_all(&mut *db).await?,
            files: sql::query_as(FILES).fetch_all(&mut *db).await?,
            refused: sql::query_as(REFUSED).fetch_all(&mut *db).await?,
            unproved: sql::query_as(UNPROVED).fetch_all(&mut *db).await?,
            builds: sql::query_as(BUILDS).fetch_all(&mut *db).await?,
            measured: sql::query_as(MEASURED).fetch_all(&mut *db).await?,
        })
    }
}
