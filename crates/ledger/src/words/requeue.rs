//! Issues the proved layout of a printed build once more, as a new build: the same copies at the same poses.

use std::collections::BTreeSet;

use crate::{
    BuildId, BuildState, EventKind, LedgerError, PartId, PartState, PutBackReport,
    base::{error::Result, sql},
    builds::nesting::group_by_part,
    store::change::LedgerChange,
};

/// States of a build that may be issued again.
const PRINTED: &[BuildState] =
    &[BuildState::Published, BuildState::Printing, BuildState::Complete, BuildState::Interrupted, BuildState::Failed];

/// Makes, within a change, a new build of the same copies at the same poses. Copies that still count as printed are put back first.
/// The new build is nesting, and is written once the originals are in the store.
pub(crate) async fn issue_again(change: &mut LedgerChange, build: BuildId, asked_by: &str) -> Result<BuildId> {
    let machine = change.ensure_build_state(build, PRINTED).await?;
    let counted: Vec<(PartId, u32)> = sql::query_as("SELECT part_id, copy FROM placement WHERE build_id = $1")
        .bind(build)
        .fetch_all(change.db())
        .await?;
    change.mark_bad(build, &counted, asked_by, true, &mut PutBackReport::default()).await?;
    let copies: Vec<(PartId, u32)> =
        sql::query_as("SELECT part_id, copy FROM bad_placement WHERE build_id = $1 ORDER BY part_id, copy")
            .bind(build)
            .fetch_all(change.db())
            .await?;
    if copies.is_empty() {
        return Err(LedgerError::NothingToNest(build));
    }
    let new = insert_repeated_build(change, build, &machine, copies.len()).await?;
    for (part, copies) in group_by_part(&copies) {
        take_copies(change, build, new, (part, &machine), &copies).await?;
    }
    let detail = format!("build {build} once more, asked for by {asked_by}");
    change.write_event(EventKind::Requeued, &machine, None, Some(new), &detail).await?;
    let parts: BTreeSet<PartId> = copies.iter().map(|&(part, _)| part).collect();
    change.update_orders_of(parts).await?;
    Ok(new)
}

async fn insert_repeated_build(
    change: &mut LedgerChange,
    build: BuildId,
    machine: &str,
    copies: usize,
) -> Result<BuildId> {
    let now = change.now;
    let new: BuildId = sql::query_scalar(
        "INSERT INTO build (machine, state, fired_by, attempts, opened_at, nesting_at, state_at, copies, repeats, material, lot) \
         VALUES ($1, 'nesting', 'requeue', 1, $2, $2, $2, $3, $4, \
         coalesce((SELECT l.material FROM loaded_material l WHERE l.machine = $1), ''), \
         coalesce((SELECT l.lot FROM loaded_material l WHERE l.machine = $1), '')) RETURNING id",
    )
    .bind(machine)
    .bind(now)
    .bind(copies as i64)
    .bind(build)
    .fetch_one(change.db())
    .await?;
    change.write_event(EventKind::Nesting, machine, None, Some(new), "requeue").await?;
    Ok(new)
}

/// Takes copies of a part at the poses that they had in another build.
async fn take_copies(
    change: &mut LedgerChange,
    from: BuildId,
    to: BuildId,
    (id, machine): (PartId, &str),
    copies: &[u32],
) -> Result<()> {
    let part = change.require_part(id).await?;
    if part.machine != machine {
        return Err(LedgerError::WrongMachine { part: id, machine: part.machine, build: from });
    }
    part.ensure_material_loaded()?;
    for &copy in copies {
        let holder: Option<BuildId> =
            sql::query_scalar("SELECT build_id FROM placement WHERE part_id = $1 AND copy = $2")
                .bind(id)
                .bind(copy)
                .fetch_optional(change.db())
                .await?;
        if let Some(build) = holder {
            return Err(LedgerError::PrintedElsewhere { part: id, copy: copy + 1, build });
        }
        sql::query(
            "INSERT INTO placement (build_id, part_id, copy, qx, qy, qz, qw, tx_mm, ty_mm, tz_mm) \
             SELECT $1, part_id, copy, qx, qy, qz, qw, tx_mm, ty_mm, tz_mm FROM bad_placement \
             WHERE build_id = $2 AND part_id = $3 AND copy = $4",
        )
        .bind(to)
        .bind(from)
        .bind(id)
        .bind(copy)
        .execute(change.db())
        .await?;
    }
    if part.state != PartState::Waiting || part.wanted_copies() < change.placed_count(id).await? {
        return Err(LedgerError::FewerWanted { part: id, build: from });
    }
    change.end_waiting(id, Some(to)).await
}
