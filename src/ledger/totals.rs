//! Totals over everything that ever was, for metrics.

use sqlx::FromRow;

use super::{Ledger, error::Result};

/// What was ever taken and built.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Totals {
    /// Profile, state, parts in it.
    pub parts: Vec<(String, String, u64)>,
    /// Profile, state, builds in it.
    pub builds: Vec<(String, String, u64)>,
    /// What was measured of every published build.
    pub measured: Vec<Measured>,
}

/// What was measured of a published build.
#[derive(Debug, Clone, Copy, PartialEq, FromRow)]
pub struct Measured {
    /// Build height, mm.
    pub height_mm: Option<f64>,
    /// Density, 0..1.
    pub density: Option<f64>,
    /// Wall seconds of the final nesting.
    pub wall_secs: Option<f64>,
}

impl Ledger {
    /// Counts of everything, as of one moment.
    pub async fn totals(&self) -> Result<Totals> {
        let mut snapshot = self.snapshot().await?;
        let db = &mut *snapshot;
        let parts = "SELECT profile, state, count(*) FROM part GROUP BY profile, state ORDER BY profile, state";
        let builds = "SELECT profile, state, count(*) FROM build GROUP BY profile, state ORDER BY profile, state";
        let measured = "SELECT height_mm, density, wall_secs FROM build WHERE published_at IS NOT NULL";
        Ok(Totals {
            parts: sqlx::query_as(parts).fetch_all(&mut *db).await?,
            builds: sqlx::query_as(builds).fetch_all(&mut *db).await?,
            measured: sqlx::query_as(measured).fetch_all(&mut *db).await?,
        })
    }
}
