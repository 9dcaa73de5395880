//! The waiting copies, in order of precedence.

use std::collections::{HashMap, HashSet};

use crate::{
    Ledger, PartId, PartRow,
    base::{error::Result, sql},
    rows::precedence::{compare_precedence, sort_by_precedence},
};

/// A waiting part with its copies that are in no build.
#[derive(Debug, Clone, PartialEq)]
pub struct WaitingPart {
    /// The part.
    pub part: PartRow,
    /// Its waiting copies, ascending, at least one.
    pub copies: Vec<u32>,
}

impl Ledger {
    /// The waiting copies of a machine that can be in its next build, in order of precedence: without parts whose file is damaged, of
    /// which something is asked, or whose material is not loaded.
    pub async fn waiting_copies(&self, machine: &str) -> Result<Vec<WaitingPart>> {
        let mut snapshot = self.begin_snapshot().await?;
        let mut parts: Vec<PartRow> = sql::select_as(
            "FROM part WHERE machine = $1 AND state = 'waiting' AND damaged_at IS NULL AND fetch_at IS NULL \
             AND question = '' AND NOT awaits_material AND replaced_by IS NULL",
        )
        .bind(machine)
        .fetch_all(&mut snapshot)
        .await?;
        sort_by_precedence(&mut parts);
        let taken: Vec<(PartId, u32)> = sql::query_as(
            "SELECT l.part_id, l.copy FROM placement l JOIN part p ON p.id = l.part_id \
             WHERE p.machine = $1 AND p.state = 'waiting'",
        )
        .bind(machine)
        .fetch_all(&mut snapshot)
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

/// Sorts waiting copies by precedence, where some stand in the open build. A part of which only some copies stand is
/// listed twice: the copies that stand, and the others.
pub fn rank_waiting_copies(waiting: Vec<WaitingPart>, stands: impl Fn(PartId, u32) -> bool) -> Vec<WaitingPart> {
    let mut ranked: Vec<(bool, WaitingPart)> = Vec::with_capacity(waiting.len());
    for WaitingPart { part, copies } in waiting {
        let (standing, others): (Vec<u32>, Vec<u32>) = copies.into_iter().partition(|&copy| stands(part.id, copy));
        for (is_standing, copies) in [(true, standing), (false, others)] {
            if !copies.is_empty() {
                ranked.push((is_standing, WaitingPart { part: part.clone(), copies }));
            }
        }
    }
    ranked.sort_by(|(one_stands, one), (other_stands, other)| {
        compare_precedence((&one.part, *one_stands), (&other.part, *other_stands))
    });
    ranked.into_iter().map(|(_, waiting)| waiting).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::{fresh, waiting};

    #[tokio::test]
    async fn a_copy_that_stands_goes_before_an_older_one_and_after_a_more_urgent_one() {
        let ledger = fresh().await;
        for name in ["a", "b", "c"] {
            waiting(&ledger.ledger, name, 2).await;
        }
        let mut line = ledger.ledger.waiting_copies("paper-200").await.unwrap();
        line[2].part.terms.priority = 51;
        let [a, b, c] = [line[0].part.id, line[1].part.id, line[2].part.id];
        let ranked = rank_waiting_copies(line, |part, copy| (part, copy) == (a, 1) || part == b);
        let order: Vec<(PartId, Vec<u32>)> = ranked.into_iter().map(|w| (w.part.id, w.copies)).collect();
        assert_eq!(order, [(c, vec![0, 1]), (a, vec![1]), (b, vec![0, 1]), (a, vec![0])]);
    }
}
