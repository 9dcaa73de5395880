//! The last steps of a build that the farm does itself: its file is proved and then put into the queue.

use crate::{
    BuildId, BuildState, Ledger, LedgerError, PartId, PartState, ProvedPlacement, Verified,
    base::{error::Result, sql},
    store::change::LedgerChange,
};

impl Ledger {
    /// nesting -> verified: the file was written and proved. `placed` must be exactly the copies of the build.
    pub async fn verify_build(&self, build: BuildId, verified: &Verified, placed: &[ProvedPlacement]) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.move_build(build, BuildState::Verified, &verified.file.file_name).await?;
        ensure_same_copies(&mut change, build, verified.measures.copies, placed).await?;
        write_result(&mut change, build, verified).await?;
        for copy in placed {
            write_pose(&mut change, build, copy).await?;
        }
        change.commit().await
    }

    /// Records that the first rename to publish a verified build is about to be tried. From now on, a missing staged
    /// file means that it was published.
    pub async fn begin_publishing(&self, build: BuildId) -> Result<()> {
        self.set_publishing(build, true).await
    }

    /// Records that nothing of a verified build was renamed, which must be certain. A missing staged file then means
    /// again that somebody removed it.
    pub async fn cancel_publishing(&self, build: BuildId) -> Result<()> {
        self.set_publishing(build, false).await
    }

    async fn set_publishing(&self, build: BuildId, is_tried: bool) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.ensure_build_state(build, &[BuildState::Verified]).await?;
        let at = is_tried.then_some(change.now);
        let set = sql::query("UPDATE build SET publishing_at = $1 WHERE id = $2").bind(at).bind(build);
        set.execute(change.db()).await?;
        change.commit().await
    }

    /// verified -> nesting: its file or its machine is not what it was, or its printer is down, so the build is nested again, beginning from
    /// the stored poses of its copies. Nobody has seen what it becomes: a yes that was said does not count for it.
    pub async fn reopen_verified_build(&self, build: BuildId, why: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.move_build(build, BuildState::Nesting, why).await?;
        sql::query(
            "UPDATE build SET verified_at = NULL, publishing_at = NULL, file_name = NULL, queue_id = NULL, \
             file_hash = NULL, file_bytes = NULL, sidecars = NULL, released_at = NULL, released_by = NULL, wall_secs = NULL \
             WHERE id = $1",
        )
        .bind(build)
        .execute(change.db())
        .await?;
        change.commit().await
    }

    /// verified -> published. Parts whose last copy is published become built.
    pub async fn publish_build(&self, build: BuildId) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.move_build(build, BuildState::Published, "").await?;
        let built: Vec<PartId> = sql::query_scalar(
            "SELECT p.id FROM part p WHERE p.state = 'batched' \
             AND p.id IN (SELECT part_id FROM placement WHERE build_id = $1) \
             AND NOT EXISTS (SELECT 1 FROM placement l JOIN build b ON b.id = l.build_id \
             WHERE l.part_id = p.id AND b.published_at IS NULL) ORDER BY p.id",
        )
        .bind(build)
        .fetch_all(change.db())
        .await?;
        for part in built {
            change.move_part(part, PartState::Built, Some(build), "").await?;
            let served = sql::query("UPDATE part SET put_back_at = NULL WHERE id = $1").bind(part);
            served.execute(change.db()).await?;
        }
        change.commit().await
    }
}

/// Checks that the placed copies are exactly the taken ones: none lost, none twice.
async fn ensure_same_copies(
    change: &mut LedgerChange,
    build: BuildId,
    claimed: u32,
    placed: &[ProvedPlacement],
) -> Result<()> {
    let taken: Vec<(PartId, u32)> =
        sql::query_as("SELECT part_id, copy FROM placement WHERE build_id = $1 ORDER BY part_id, copy")
            .bind(build)
            .fetch_all(change.db())
            .await?;
    let mut copies: Vec<(PartId, u32)> = placed.iter().map(|p| (p.part, p.copy)).collect();
    copies.sort_unstable();
    if copies != taken || claimed as usize != placed.len() {
        return Err(LedgerError::PlacementsDiffer { build, taken: taken.len(), placed: placed.len() });
    }
    if placed.is_empty() {
        return Err(LedgerError::NothingToNest(build));
    }
    Ok(())
}

async fn write_result(change: &mut LedgerChange, build: BuildId, verified: &Verified) -> Result<()> {
    sql::query(
        "UPDATE build SET file_name = $1, queue_id = $2, file_hash = $3, file_bytes = $4, height_mm = $5, density = $6, \
         lower_bound_mm = $7, layers = $8, part_volume_mm3 = $9, copies = $10, clearance_mm = $11, clearance_proved_mm = $12, \
         cpu_secs = coalesce(cpu_secs, 0) + $13, wall_secs = coalesce(wall_secs, 0) + $14, evaluations = $15, seed = $16, method = $17, version = $18, \
         profile_snapshot = $19, curve = $20, sidecars = $21 WHERE id = $22",
    )
    .bind(&verified.file.file_name)
    .bind(&verified.file.queue_id)
    .bind(&verified.file.file_hash)
    .bind(verified.file.file_bytes as i64)
    .bind(verified.measures.height_mm)
    .bind(verified.measures.density)
    .bind(verified.measures.lower_bound_mm)
    .bind(verified.measures.layers)
    .bind(verified.measures.part_volume_mm3)
    .bind(verified.measures.copies)
    .bind(verified.measures.clearance_mm)
    .bind(verified.measures.clearance_proved_mm)
    .bind(verified.search.cpu_secs)
    .bind(verified.search.wall_secs)
    .bind(verified.search.evaluations as i64)
    .bind(verified.search.seed.cast_signed())
    .bind(&verified.search.method)
    .bind(&verified.search.version)
    .bind(&verified.profile_snapshot)
    .bind(verified.search.curve_json())
    .bind(serde_json::to_string(&verified.file.sidecars).ok())
    .bind(build)
    .execute(change.db())
    .await?;
    Ok(())
}

async fn write_pose(change: &mut LedgerChange, build: BuildId, placed: &ProvedPlacement) -> Result<()> {
    let ([qx, qy, qz, qw], [x, y, z]) = (placed.rotation, placed.translation_mm);
    let direction = |axis: usize| placed.removal.map(|removal| removal.direction[axis]);
    sql::query(
        "UPDATE placement SET qx = $1, qy = $2, qz = $3, qw = $4, tx_mm = $5, ty_mm = $6, tz_mm = $7, \
         drawn = $8, way_x = $9, way_y = $10, way_z = $11 WHERE part_id = $12 AND copy = $13 AND build_id = $14",
    )
    .bind(qx)
    .bind(qy)
    .bind(qz)
    .bind(qw)
    .bind(x)
    .bind(y)
    .bind(z)
    .bind(placed.removal.map(|removal| removal.position))
    .bind(direction(0))
    .bind(direction(1))
    .bind(direction(2))
    .bind(placed.part)
    .bind(placed.copy)
    .bind(build)
    .execute(change.db())
    .await?;
    Ok(())
}
