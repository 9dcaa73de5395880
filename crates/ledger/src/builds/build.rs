//! Builds: parts of one machine that are printed together, with one build file and one height.

use crate::{
    BuildId, BuildState, Ledger, UtcTimestamp,
    base::{error::Result, sql},
    rows::build_row::{BuildRow, OpenLayout},
};

impl Ledger {
    /// Returns the open build of a machine, and creates it if there is none.
    pub async fn open_build(&self, machine: &str) -> Result<BuildRow> {
        let open = "FROM build WHERE machine = $1 AND state = 'open'";
        if let Some(build) = sql::select_as(open).bind(machine).fetch_optional(self.reader()?).await? {
            return Ok(build);
        }
        let mut change = self.begin_change().await?;
        let now = change.now;
        sql::query(
            "INSERT INTO build (machine, state, opened_at, state_at) VALUES ($1, 'open', $2, $3) \
             ON CONFLICT (machine) WHERE state = 'open' DO NOTHING",
        )
        .bind(machine)
        .bind(now)
        .bind(now)
        .execute(change.db())
        .await?;
        let build = sql::select_as(open).bind(machine).fetch_one(change.db()).await?;
        change.commit().await?;
        Ok(build)
    }

    /// Deletes the open build of a machine that does not exist any more; it holds no copy. Its events are kept without
    /// the build number.
    pub async fn delete_open_build(&self, machine: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        sql::query(
            "UPDATE event SET build_id = NULL WHERE build_id IN \
             (SELECT id FROM build WHERE machine = $1 AND state = 'open')",
        )
        .bind(machine)
        .execute(change.db())
        .await?;
        let searched =
            "DELETE FROM night_search WHERE build_id IN (SELECT id FROM build WHERE machine = $1 AND state = 'open')";
        sql::query(searched).bind(machine).execute(change.db()).await?;
        let drop = sql::query("DELETE FROM build WHERE machine = $1 AND state = 'open'").bind(machine);
        drop.execute(change.db()).await?;
        change.commit().await
    }

    /// Stores the layout of an open or nesting build. One that lacks copies of a nesting build tells nothing of its height.
    pub async fn save_layout(&self, build: BuildId, layout: &OpenLayout) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.ensure_build_state(build, &[BuildState::Open, BuildState::Nesting]).await?;
        sql::query(
            "UPDATE build SET layout = $1, height_mm = CASE WHEN state = 'open' OR copies = $5 THEN $2 END, \
             density = CASE WHEN state = 'open' OR copies = $5 THEN $3 END, \
             part_volume_mm3 = CASE WHEN state = 'open' OR copies = $5 THEN $4 END, \
             copies = CASE state WHEN 'open' THEN $5 ELSE copies END WHERE id = $6",
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

    /// Forgets the layouts of the open build of a machine, in which nothing stands any more.
    pub async fn forget_layout(&self, machine: &str) -> Result<()> {
        let laid_out = "SELECT id FROM build WHERE machine = $1 AND state = 'open' AND layout IS NOT NULL";
        let query = sql::query_scalar(laid_out).bind(machine);
        let build: Option<BuildId> = query.fetch_optional(self.reader()?).await?;
        let Some(build) = build else { return Ok(()) };
        let mut change = self.begin_change().await?;
        change.ensure_build_state(build, &[BuildState::Open]).await?;
        sql::query(
            "UPDATE build SET layout = NULL, height_mm = NULL, density = NULL, part_volume_mm3 = NULL, copies = NULL \
             WHERE id = $1",
        )
        .bind(build)
        .execute(change.db())
        .await?;
        sql::query("DELETE FROM night_search WHERE build_id = $1").bind(build).execute(change.db()).await?;
        change.commit().await
    }

    /// Adds CPU seconds of nesting for an open or nesting build.
    pub async fn add_cpu_secs(&self, build: BuildId, cpu_secs: f64) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.tell_nobody();
        change.ensure_build_state(build, &[BuildState::Open, BuildState::Nesting]).await?;
        let add = sql::query("UPDATE build SET cpu_secs = coalesce(cpu_secs, 0) + $1 WHERE id = $2");
        add.bind(cpu_secs).bind(build).execute(change.db()).await?;
        change.commit().await
    }

    /// All builds in a state, oldest first.
    pub async fn builds_in_state(&self, state: BuildState) -> Result<Vec<BuildRow>> {
        let query = sql::select_as("FROM build WHERE state = $1 ORDER BY id").bind(state);
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// The builds of a machine that have failed since then before they were published, and why; the oldest first.
    pub async fn failures_since(&self, machine: &str, since: UtcTimestamp) -> Result<Vec<(BuildId, String)>> {
        let query = sql::query_as(
            "SELECT id, reason FROM build WHERE state = 'failed' AND machine = $1 AND published_at IS NULL \
             AND state_at >= $2 ORDER BY id",
        );
        Ok(query.bind(machine).bind(since).fetch_all(self.reader()?).await?)
    }

    /// Finds a build by its number.
    pub async fn find_build(&self, id: BuildId) -> Result<Option<BuildRow>> {
        let query = sql::select_as("FROM build WHERE id = $1").bind(id);
        Ok(query.fetch_optional(self.reader()?).await?)
    }
}
