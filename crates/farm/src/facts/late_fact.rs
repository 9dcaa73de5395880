//! Which parts came late, or are late. Where nobody told that a print ended, it ends as its machine plans it, or as long after its begin as
//! such prints take.

use std::collections::BTreeMap;

use anyhow::Result;
use jiff::Timestamp;
use ledger::{LatePart, Ledger, PartId, UtcTimestamp};
use settings::MachineProfile;

use super::build_fact::ends_of;
use crate::planning::{MachinePlan, read_occupation};

/// The parts with a due date in a span of time that came late or are late, by due date.
///
/// # Errors
/// The ledger cannot be read.
pub async fn read_late_parts(
    ledger: &Ledger,
    profiles: &BTreeMap<String, MachineProfile>,
    plans: &[MachinePlan],
    (since, until): (Timestamp, Timestamp),
    now: Timestamp,
) -> Result<Vec<LatePart>> {
    let mut late = ledger.late_parts(since, until, now).await?;
    let mut ended: BTreeMap<PartId, LatePart> = BTreeMap::new();
    for print in ledger.untold_prints(since, until).await? {
        let Some(profile) = profiles.get(&print.part.machine) else { continue };
        let ends_at = match ends_of(print.build, plans) {
            Some(at) => at.0,
            None => {
                let times = read_occupation(ledger, profile, now).await?.times;
                let begun_at = print.part.done_at.map_or(now, |at| at.0);
                begun_at.checked_add(times.occupied(print.height_mm)).unwrap_or(Timestamp::MAX)
            }
        };
        let part = ended.entry(print.part.part).or_insert(LatePart { done_at: None, ..print.part });
        part.done_at = part.done_at.max(Some(UtcTimestamp(ends_at)));
    }
    // Those that still go on are in the plan.
    let is_late = |part: &LatePart| part.done_at.is_some_and(|at| at > part.due_at && at.0 <= now);
    late.extend(ended.into_values().filter(is_late));
    late.sort_by_key(|part| (part.due_at, part.part));
    Ok(late)
}
