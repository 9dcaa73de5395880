//! The waiting copies, in order of precedence.

use std::collections::{HashMap, HashSet};

use super::{Ledger, PartId, PartRow, error::Result};

/// A waiting part with its copies that are in no build.
#[derive(Debug, Clone, PartialEq)]
pub struct WaitingPart {
    /// The part.
    pub part: PartRow,
    /// Its waiting copies, ascending, at least one.
    pub copies: Vec<u32>,
}

impl Ledger {
    /// The waiting copies of a profile, without parts whose file is damaged, in order of precedence: priority, due
    /// date, age.
    pub async fn waiting_copies(&self, profile: &str) -> Result<Vec<WaitingPart>> {
        let mut snapshot = self.begin_snapshot().await?;
        let parts: Vec<PartRow> = sqlx::query_as(
            "SELECT * FROM part WHERE profile = ? AND state = 'waiting' AND damaged_at IS NULL AND fetch_at IS NULL \
             AND question = '' AND replaced_by IS NULL \
             ORDER BY put_back_at IS NULL, put_back_at, priority DESC, due_at IS NULL, due_at, claimed_at, id",
        )
        .bind(profile)
        .fetch_all(&mut *snapshot)
        .await?;
        let taken: Vec<(PartId, u32)> = sqlx::query_as(
            "SELECT l.part_id, l.copy FROM placement l JOIN part p ON p.id = l.part_id \
             WHERE p.profile = ? AND p.state = 'waiting'",
        )
        .bind(profile)
        .fetch_all(&mut *snapshot)
        .await?;
        let mut taken_copies: HashMap<PartId, HashSet<u32>> = HashMap::new();
        for (part, copy) in taken {
            taken_copies.entry(part).or_default().insert(copy);
        }
        let waiting = parts.into_iter().map(|part| {
            let taken = taken_copies.get(&part.id);
            let free = (0..part.owed.copies).filter(|copy| !taken.is_some_and(|t| t.contains(copy)));
            let most = part.wanted_copies() as usize - taken.map_or(0, HashSet::len);
            let copies = free.take(most).collect();
            WaitingPart { part, copies }
        });
        Ok(waiting.collect())
    }
}
