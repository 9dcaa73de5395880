//! The last steps of a build by the farm's own hand: its file is proved, then it is in the queue.

use super::{
    BuildId, BuildState, Ledger, LedgerError, PartId, PartState, PlacedCopy, Verified, change::Change, error::Result,
};

impl Ledger {
    /// nesting -> verified: the file is written and proved. `placed` must be exactly the copies of the build.
    pub async fn verify_build(&self, build: BuildId, verified: &Verified, placed: &[PlacedCopy]) -> Result<()> {
        let mut change = self.change().await?;
        change.move_build(build, BuildState::Verified, &verified.file.file_name).await?;
        demand_same_copies(&mut change, build, verified.measures.copies, placed).await?;
        write_result(&mut change, build, verified).await?;
        for copy in placed {
            write_pose(&mut change, build, copy).await?;
        }
        change.commit().await
    }

    /// The first rename that publishes a verified build is about to be tried: from now on "gone" means published.
    pub async fn begin_publishing(&self, build: BuildId) -> Result<()> {
        self.set_publishing(build, true).await
    }

    /// Nothing of a verified build was renamed, and it is certain: "gone" means removed by somebody again.
    pub async fn end_publishing(&self, build: BuildId) -> Result<()> {
        self.set_publishing(build, false).await
    }

    async fn set_publishing(&self, build: BuildId, is_tried: bool) -> Result<()> {
        let mut change = self.change().await?;
        change.demand(build, &[BuildState::Verified]).await?;
        let at = is_tried.then_some(change.now);
        let set = sqlx::query("UPDATE build SET publishing_at = ? WHERE id = ?").bind(at).bind(build);
        set.execute(change.db()).await?;
        change.commit().await
    }

    /// verified -> nesting: its staged file is not the proved one any more, so that it is made again, from the poses that its
    /// copies have.
    pub async fn write_again(&self, build: BuildId, why: &str) -> Result<()> {
        let mut change = self.change().await?;
        change.move_build(build, BuildState::Nesting, why).await?;
        sqlx::query(
            "UPDATE build SET verified_at = NULL, publishing_at = NULL, file_name = NULL, queue_id = NULL, \
             file_hash = NULL, file_bytes = NULL, sidecars = NULL WHERE id = ?",
        )
        .bind(build)
        .execute(change.db())
        .await?;
        change.commit().await
    }

    /// verified -> published; parts whose last copy is published become built.
    pub async fn publish_build(&self, build: BuildId) -> Result<()> {
        let mut change = self.change().await?;
        change.move_build(build, BuildState::Published, "").await?;
        let built: Vec<PartId> = sqlx::query_scalar(
            "SELECT p.id FROM part p WHERE p.state = 'batched' \
             AND p.id IN (SELECT part_id FROM placement WHERE build_id = ?) \
             AND NOT EXISTS (SELECT 1 FROM placement l JOIN build b ON b.id = l.build_id \
             WHERE l.part_id = p.id AND b.published_at IS NULL) ORDER BY p.id",
        )
        .bind(build)
        .fetch_all(change.db())
        .await?;
        for part in built {
            change.move_part(part, PartState::Built, Some(build), "").await?;
        }
        change.commit().await
    }
}

/// What is placed must be what was taken: no copy lost, none twice.
async fn demand_same_copies(change: &mut Change, build: BuildId, claimed: u32, placed: &[PlacedCopy]) -> Result<()> {
    let taken: Vec<(PartId, u32)> =
        sqlx::query_as("SELECT part_id, copy FROM placement WHERE build_id = ? ORDER BY part_id, copy")
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

async fn write_result(change: &mut Change, build: BuildId, verified: &Verified) -> Result<()> {
    sqlx::query(
        "UPDATE build SET file_name = ?, queue_id = ?, file_hash = ?, file_bytes = ?, height_mm = ?, density = ?, \
         lower_bound_mm = ?, layers = ?, part_volume_mm3 = ?, copies = ?, clearance_mm = ?, clearance_proved_mm = ?, \
         cpu_secs = coalesce(cpu_secs, 0) + ?, wall_secs = ?, evaluations = ?, seed = ?, method = ?, version = ?, \
         profile_snapshot = ?, curve = ?, sidecars = ? WHERE id = ?",
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

async fn write_pose(change: &mut Change, build: BuildId, placed: &PlacedCopy) -> Result<()> {
    let ([qx, qy, qz, qw], [x, y, z]) = (placed.rotation, placed.translation_mm);
    let way = |axis: usize| placed.drawn.map(|drawn| drawn.way[axis]);
    sqlx::query(
        "UPDATE placement SET qx = ?, qy = ?, qz = ?, qw = ?, tx_mm = ?, ty_mm = ?, tz_mm = ?, \
         drawn = ?, way_x = ?, way_y = ?, way_z = ? WHERE part_id = ? AND copy = ? AND build_id = ?",
    )
    .bind(qx)
    .bind(qy)
    .bind(qz)
    .bind(qw)
    .bind(x)
    .bind(y)
    .bind(z)
    .bind(placed.drawn.map(|drawn| drawn.place))
    .bind(way(0))
    .bind(way(1))
    .bind(way(2))
    .bind(placed.part)
    .bind(placed.copy)
    .bind(build)
    .execute(change.db())
    .await?;
    Ok(())
}
