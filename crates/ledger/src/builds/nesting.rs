//! A build that is nested: its copies are taken, and released again if they found no place or the build failed. The key
//! of the placements ensures that a copy is in one build only.

use std::collections::{BTreeMap, BTreeSet};

use crate::{
    BuildId, BuildState, Ledger, LedgerError, PartId, PartState,
    base::{error::Result, sql},
    store::change::LedgerChange,
};

impl Ledger {
    /// open -> nesting: takes exactly these copies. Parts whose last copy is taken become batched.
    pub async fn begin_nesting(&self, build: BuildId, fired_by: &str, copies: &[(PartId, u32)]) -> Result<()> {
        if copies.is_empty() {
            return Err(LedgerError::NothingToNest(build));
        }
        let mut change = self.begin_change().await?;
        let machine = change.move_build(build, BuildState::Nesting, fired_by).await?;
        // A layout that lacks some of them tells nothing of their height.
        sql::query(
            "UPDATE build SET attempts = 1, fired_by = $1, \
             material = coalesce((SELECT l.material FROM loaded_material l WHERE l.machine = build.machine), ''), \
             lot = coalesce((SELECT l.lot FROM loaded_material l WHERE l.machine = build.machine), ''), height_mm = CASE WHEN copies = $2 THEN height_mm END, \
             density = CASE WHEN copies = $2 THEN density END, \
             part_volume_mm3 = CASE WHEN copies = $2 THEN part_volume_mm3 END, copies = $2 WHERE id = $3",
        )
        .bind(fired_by)
        .bind(copies.len() as i64)
        .bind(build)
        .execute(change.db())
        .await?;
        for (part, copies) in group_by_part(copies) {
            insert_placements(&mut change, build, &machine, part, &copies).await?;
        }
        change.commit().await
    }

    /// Counts another attempt of a nesting build, and returns the number of attempts.
    pub async fn begin_attempt(&self, build: BuildId) -> Result<u32> {
        let mut change = self.begin_change().await?;
        change.ensure_build_state(build, &[BuildState::Nesting]).await?;
        let attempts = sql::query_scalar("UPDATE build SET attempts = attempts + 1 WHERE id = $1 RETURNING attempts")
            .bind(build)
            .fetch_one(change.db())
            .await?;
        change.commit().await?;
        Ok(attempts)
    }

    /// Counts a search for a build, before it starts.
    pub async fn begin_search(&self, build: BuildId) -> Result<()> {
        self.count_searches(build, "UPDATE build SET searches = searches + 1 WHERE id = $1").await
    }

    /// Records that a search for a build finished.
    pub async fn end_search(&self, build: BuildId) -> Result<()> {
        self.count_searches(build, "UPDATE build SET searches = 0 WHERE id = $1").await
    }

    /// The search of a nesting build was stopped before its time: it goes on later. That was no attempt, and what it took is counted.
    pub async fn leave_search(&self, build: BuildId, cpu_secs: f64, wall_secs: f64) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.ensure_build_state(build, &[BuildState::Nesting]).await?;
        let left = sql::query(
            "UPDATE build SET searches = 0, attempts = CASE WHEN attempts > 0 THEN attempts - 1 ELSE 0 END, \
             cpu_secs = coalesce(cpu_secs, 0) + $1, wall_secs = coalesce(wall_secs, 0) + $2 WHERE id = $3",
        );
        left.bind(cpu_secs).bind(wall_secs).bind(build).execute(change.db()).await?;
        change.commit().await
    }

    async fn count_searches(&self, build: BuildId, count: &'static str) -> Result<()> {
        let mut change = self.begin_change().await?;
        sql::query(count).bind(build).execute(change.db()).await?;
        change.commit().await
    }

    /// Releases copies of a nesting build; `why` is told in the events of their parts, which wait again and keep their age.
    pub async fn release_copies(&self, build: BuildId, copies: &[(PartId, u32)], why: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.ensure_build_state(build, &[BuildState::Nesting]).await?;
        delete_placements(&mut change, build, copies, why).await?;
        change.commit().await
    }

    /// nesting -> failed: all its copies wait again.
    pub async fn fail_build(&self, build: BuildId, reason: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.ensure_build_state(build, &[BuildState::Nesting]).await?;
        let copies: Vec<(PartId, u32)> = sql::query_as("SELECT part_id, copy FROM placement WHERE build_id = $1")
            .bind(build)
            .fetch_all(change.db())
            .await?;
        delete_placements(&mut change, build, &copies, "the build failed").await?;
        change.move_build(build, BuildState::Failed, reason).await?;
        // What was forecast, or proved for a machine that has changed since, does not apply any more.
        sql::query(
            "UPDATE build SET height_mm = NULL, density = NULL, part_volume_mm3 = NULL, lower_bound_mm = NULL, layers = NULL, \
             clearance_proved_mm = NULL WHERE id = $1",
        )
        .bind(build)
        .execute(change.db())
        .await?;
        change.commit().await
    }
}

/// Groups copies by their part.
pub(crate) fn group_by_part(copies: &[(PartId, u32)]) -> BTreeMap<PartId, Vec<u32>> {
    let mut parts: BTreeMap<PartId, Vec<u32>> = BTreeMap::new();
    for &(part, copy) in copies {
        parts.entry(part).or_default().push(copy);
    }
    parts
}

/// Inserts placements for copies of one part.
async fn insert_placements(
    change: &mut LedgerChange,
    build: BuildId,
    machine: &str,
    id: PartId,
    copies: &[u32],
) -> Result<()> {
    let part = change.require_part(id).await?;
    if part.machine != machine {
        return Err(LedgerError::WrongMachine { part: id, machine: part.machine, build });
    }
    if part.state != PartState::Waiting {
        return Err(LedgerError::NotWaiting { part: id, state: part.state });
    }
    part.ensure_material_loaded()?;
    for &copy in copies {
        if copy >= part.owed.copies {
            return Err(LedgerError::NoSuchCopy { part: id, copy });
        }
        let place =
            sql::query("INSERT INTO placement (part_id, copy, build_id) VALUES ($1, $2, $3) ON CONFLICT DO NOTHING");
        if place.bind(id).bind(copy).bind(build).execute(change.db()).await? == 0 {
            let holder = sql::query_scalar("SELECT build_id FROM placement WHERE part_id = $1 AND copy = $2");
            let build = holder.bind(id).bind(copy).fetch_one(change.db()).await?;
            return Err(LedgerError::CopyTaken { part: id, copy, build });
        }
    }
    let placed = change.placed_count(id).await?;
    // Whoever has taken copies back has been told so, and does not hear that they were nested meanwhile.
    let wanted = part.wanted_copies().saturating_sub(change.copies_asked_back(id).await?);
    if placed > wanted {
        return Err(LedgerError::AskedBack(id));
    }
    if placed == part.wanted_copies() {
        change.move_part(id, PartState::Batched, Some(build), "").await?;
    }
    Ok(())
}

/// Removes copies from a build.
async fn delete_placements(
    change: &mut LedgerChange,
    build: BuildId,
    copies: &[(PartId, u32)],
    why: &str,
) -> Result<()> {
    for &(part, copy) in copies {
        let lift = sql::query("DELETE FROM placement WHERE part_id = $1 AND copy = $2 AND build_id = $3");
        if lift.bind(part).bind(copy).bind(build).execute(change.db()).await? == 0 {
            return Err(LedgerError::NotInBuild { part, copy, build });
        }
    }
    let parts: BTreeSet<PartId> = copies.iter().map(|&(part, _)| part).collect();
    for part in parts {
        if change.require_part(part).await?.state == PartState::Batched {
            change.move_part(part, PartState::Waiting, Some(build), why).await?;
        }
    }
    let count = "UPDATE build SET copies = (SELECT count(*) FROM placement WHERE build_id = $1) WHERE id = $1";
    sql::query(count).bind(build).execute(change.db()).await?;
    Ok(())
}
