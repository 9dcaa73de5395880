//! How far the search for an open build that waits has come. It goes on after the search for the last arrival, in rounds.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    BuildId, BuildState, Ledger,
    base::{
        error::Result,
        sql::{self, sql_row},
        text_column::own_word,
    },
};

/// Whether the search for an open build that waits goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum NightState {
    /// It goes on whenever a thread is free.
    GoesOn,
    /// A round gained so little that the next one is not worth its time.
    StandsStill,
    /// It has taken the CPU time that it may take.
    UsedUp,
    /// It failed, or the daemon ended during three searches in a row.
    GivenUp,
}

own_word!(NightState);

/// How far the search for an open build that waits has come.
#[derive(Debug, Clone, PartialEq)]
pub struct NightSearchRow {
    /// BLAKE3 of the copies and rules that it is for, 64 hex digits.
    pub problem: String,
    /// Whether it goes on.
    pub state: NightState,
    /// The round, from 0. Each has twice the CPU time of the one before.
    pub round: u32,
    /// CPU seconds that this round has taken so far.
    pub round_cpu_secs: f64,
    /// Height of the layout at the begin of the round, mm.
    pub round_height_mm: f64,
    /// CPU seconds of all rounds since the last arrival.
    pub cpu_secs: f64,
    /// Height of the layout after the search for the last arrival, mm.
    pub first_height_mm: f64,
    /// Searches that were started since the last one that ended.
    pub starts: u32,
    /// JSON, the layouts to go on from, the lowest first.
    pub pool: String,
}

sql_row!(NightSearchRow {
    problem,
    state,
    round,
    round_cpu_secs,
    round_height_mm,
    cpu_secs,
    first_height_mm,
    starts,
    pool
});

impl Ledger {
    /// How far the search for an open build has come; `None` = it has not begun.
    pub async fn find_night_search(&self, build: BuildId) -> Result<Option<NightSearchRow>> {
        let query = sql::select_as("FROM night_search WHERE build_id = $1");
        Ok(query.bind(build).fetch_optional(self.reader()?).await?)
    }

    /// Stores how far the search for an open build has come.
    pub async fn save_night_search(&self, build: BuildId, row: &NightSearchRow) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.tell_nobody();
        change.ensure_build_state(build, &[BuildState::Open]).await?;
        sql::query("DELETE FROM night_search WHERE build_id = $1").bind(build).execute(change.db()).await?;
        sql::query(
            "INSERT INTO night_search (build_id, problem, state, round, round_cpu_secs, round_height_mm, cpu_secs, \
             first_height_mm, starts, pool) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10)",
        )
        .bind(build)
        .bind(&row.problem)
        .bind(row.state)
        .bind(row.round)
        .bind(row.round_cpu_secs)
        .bind(row.round_height_mm)
        .bind(row.cpu_secs)
        .bind(row.first_height_mm)
        .bind(row.starts)
        .bind(&row.pool)
        .execute(change.db())
        .await?;
        change.commit().await
    }

    /// Forgets the search for an open build that is not searched any more while it waits.
    pub async fn delete_night_search(&self, build: BuildId) -> Result<()> {
        let mut change = self.begin_change().await?;
        sql::query("DELETE FROM night_search WHERE build_id = $1").bind(build).execute(change.db()).await?;
        change.commit().await
    }
}
