//! Parts whose stored file is damaged. They wait until the same file is dropped again.

use crate::{
    EventKind, Ledger, NewPartRow, PartId, PartRow,
    base::{error::Result, sql},
    store::change::LedgerChange,
};

impl Ledger {
    /// Makes every part of this node's machines that needs this stored file wait until the file is intact again.
    pub async fn mark_damaged(&self, hash: &str, why: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        let parts: Vec<(PartId, String)> = sql::query_as(
            "SELECT id, machine FROM part WHERE content_hash = $1 AND state IN ('claimed', 'waiting') AND damaged_at IS NULL \
             AND ($2 = '' OR machine NOT IN (SELECT machine FROM station WHERE node NOT IN ('', $2)))",
        )
        .bind(hash)
        .bind(self.node())
        .fetch_all(change.db())
        .await?;
        let now = change.now;
        for (part, machine) in parts {
            let mark = sql::query("UPDATE part SET damaged_at = $1 WHERE id = $2").bind(now).bind(part);
            mark.execute(change.db()).await?;
            change.write_event(EventKind::Damaged, &machine, Some(part), None, why).await?;
        }
        change.commit().await
    }

    /// Records that the stored file is intact again, so its parts continue.
    pub async fn mark_whole(&self, hash: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        clear_damage(&mut change, hash, self.node()).await?;
        change.commit().await
    }

    /// The parts that wait for their file to be dropped again, oldest first.
    pub async fn damaged_parts(&self) -> Result<Vec<PartRow>> {
        let query = sql::select_as(
            "FROM part WHERE damaged_at IS NOT NULL AND state IN ('claimed', 'waiting', 'batched') ORDER BY id",
        );
        Ok(query.fetch_all(self.reader()?).await?)
    }
}

impl LedgerChange {
    /// Takes a claim whose file is in the store as the replacement for the damaged file of a part of the same machine. All parts of that
    /// file continue. Returns the part; `None` = no part was waiting for this file, so the claim is a new order. Safe to repeat, also when
    /// the claim is found again after a crash. `node` = who has the store, "" = there is one.
    pub async fn take_replacement(&mut self, drop: &NewPartRow, node: &str) -> Result<Option<PartId>> {
        let NewPartRow { claim, machine, content_hash: hash, .. } = drop;
        let known = sql::query_scalar("SELECT part_id FROM replacement WHERE claim = $1").bind(claim);
        if let Some(part) = known.fetch_optional(self.db()).await? {
            return Ok(Some(part));
        }
        let asked: Vec<(PartId, bool)> = sql::query_as(
            "SELECT id, machine = $2 AND state IN ('claimed', 'waiting', 'batched') \
             AND NOT EXISTS (SELECT 1 FROM part WHERE claim = $3) \
             FROM part WHERE content_hash = $1 AND damaged_at IS NOT NULL ORDER BY id",
        )
        .bind(hash)
        .bind(machine)
        .bind(claim)
        .fetch_all(self.db())
        .await?;
        if asked.is_empty() {
            return Ok(None);
        }
        clear_damage(self, hash, node).await?;
        let Some(&(part, _)) = asked.iter().find(|(_, is_meant)| *is_meant) else { return Ok(None) };
        let now = self.now;
        sql::query("INSERT INTO replacement (claim, part_id, content_hash, taken_at) VALUES ($1, $2, $3, $4)")
            .bind(claim)
            .bind(part)
            .bind(hash)
            .bind(now)
            .execute(self.db())
            .await?;
        self.write_event(EventKind::Healed, machine, Some(part), None, "the same file was dropped again").await?;
        Ok(Some(part))
    }
}

/// The parts of a file that is intact again in the store of a node continue: they arrive among the waiting ones. Other nodes have stores of
/// their own; "" = there are none.
async fn clear_damage(change: &mut LedgerChange, hash: &str, node: &str) -> Result<()> {
    let clear = sql::query_scalar(
        "UPDATE part SET damaged_at = NULL WHERE content_hash = $1 AND damaged_at IS NOT NULL \
         AND ($2 = '' OR machine NOT IN (SELECT machine FROM station WHERE node NOT IN ('', $2))) RETURNING id",
    );
    let parts: Vec<PartId> = clear.bind(hash).bind(node).fetch_all(change.db()).await?;
    change.begin_to_wait_again(&parts).await
}

#[cfg(test)]
mod tests {
    use crate::{NewPartRow, PartId, RecordedAs, fixtures::*};

    #[tokio::test]
    async fn a_part_whose_file_is_damaged_waits_until_the_file_is_dropped_again_which_is_no_order() {
        let ledger = fresh().await;
        let id = waiting(&ledger, "a", 2).await;
        let part = ledger.find_part(id).await.unwrap().unwrap();
        let (machine, hash) = (part.machine.as_str(), part.file.content_hash.as_str());
        // The part that a claim brings its file again; `None` = it is an order.
        let drop_again = async |claim: &str, machine: &str| -> Option<PartId> {
            let (machine, content_hash) = (machine.to_owned(), hash.to_owned());
            let drop = NewPartRow { machine, content_hash, ..new_part(claim, 2) };
            let other = NewPartRow { content_hash: "0".repeat(64), ..new_part(&format!("{claim} beside"), 1) };
            let recorded = ledger.record_drops(&[(&other, true), (&drop, true)]).await.unwrap();
            assert_ne!(recorded[0].outcome, RecordedAs::Replacement);
            (recorded[1].outcome == RecordedAs::Replacement).then_some(recorded[1].id)
        };
        assert_eq!(drop_again("b", machine).await, None, "nobody asked for it again");
        ledger.mark_damaged(hash, "it was damaged").await.unwrap();
        ledger.mark_damaged(hash, "it was damaged").await.unwrap();
        assert!(ledger.waiting_copies(machine).await.unwrap().is_empty());
        assert_eq!(ledger.damaged_parts().await.unwrap().len(), 2);
        // The second time it is found again after a crash, beside others.
        for _ in 0..2 {
            assert_eq!(drop_again("c", machine).await, Some(id));
        }
        assert_eq!(ledger.waiting_copies(machine).await.unwrap()[0].copies, [0, 1]);
        assert_eq!(drop_again("d", machine).await, None, "it was asked for once");
        assert!(ledger.drop_counts_by_hash().await.unwrap().contains(&(hash.to_owned(), 4)), "with its replacement");
        ledger.mark_damaged(hash, "it was damaged").await.unwrap();
        assert_eq!(drop_again("e", "another machine").await, None, "it is an order there");
        assert!(ledger.damaged_parts().await.unwrap().is_empty(), "and the file is whole");
        ledger.mark_damaged(hash, "it was damaged").await.unwrap();
        ledger.mark_whole(hash).await.unwrap();
        assert!(ledger.damaged_parts().await.unwrap().is_empty());
    }
}
