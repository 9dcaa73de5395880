//! Revisions: a file that is dropped again under the same name in the same order replaces what still waits of the earlier one, as does
//! a file that is taken once more because its writer went on.

use crate::{
    EventKind, Ledger, NewPartRow, PartId, PartRow,
    base::{error::Result, sql},
    store::change::LedgerChange,
};

/// What a revision without a ticket of its own takes over of the part that it replaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TakenOver {
    /// Nothing: it has a ticket, or replaces several parts.
    Nothing,
    /// The due date and the note: the rest stands in the file itself.
    Date,
    /// All that was asked with it.
    All,
}

impl TakenOver {
    /// For a file of this name that replaces so many parts.
    fn of_claim(name: &str, has_ticket: bool, replaced: usize) -> Self {
        match replaced {
            _ if has_ticket => Self::Nothing,
            _ if build_file::is_camspec_name(name) => Self::Date,
            1 => Self::All,
            // What was asked with a file of several solids is not known any more for the file as a whole.
            _ => Self::Nothing,
        }
    }
}

/// End of the detail of the event of a revision that takes over how many copies are wanted in all, however many its file holds.
const IN_ALL: &str = ", with all that was asked with it, and not more copies in all";

impl Ledger {
    /// Earlier revisions that a newer one replaced and that are not taken out yet, oldest first.
    pub async fn replaced_parts(&self) -> Result<Vec<PartRow>> {
        let query =
            sql::select_as("FROM part WHERE replaced_by IS NOT NULL AND state IN ('claimed', 'waiting') ORDER BY id");
        Ok(query.fetch_all(self.reader()?).await?)
    }
}

/// Takes over how often the file of a part was wanted. Returns whether that is not known, so that the copies wanted are those in all.
async fn take_copies_over(change: &mut LedgerChange, old: &PartRow, new: PartId) -> Result<bool> {
    let held = sql::query_scalar("SELECT file_copies FROM part WHERE id = $1").bind(old.id);
    let held: Option<u32> = held.fetch_one(change.db()).await?;
    let wanted = old.wanted_copies();
    let (copies, is_in_all) = match held {
        // Nobody has read yet what is in it: its copies are those of its ticket or its name.
        _ if old.measures.triangles.is_none() => (wanted, false),
        Some(held) if held > 0 && wanted.is_multiple_of(held) => (wanted / held, false),
        _ => (wanted, true),
    };
    let set = sql::query("UPDATE part SET copies = $1 WHERE id = $2 AND state = 'claimed'").bind(copies).bind(new);
    set.execute(change.db()).await?;
    Ok(is_in_all)
}

impl LedgerChange {
    /// A part that was just claimed replaces those that it is a revision of: the same name in the same named order, still waiting, with
    /// other content, and no copy of it in a build. What was taken of the same file before needs no order.
    pub(super) async fn replace_revised_parts(&mut self, new: PartId, row: &NewPartRow) -> Result<()> {
        let query = sql::select_as(
            "FROM part WHERE id IN (SELECT p.id FROM part n JOIN part p ON p.order_name = n.order_name \
             WHERE n.id = $1 AND n.state = 'claimed' AND n.order_name <> '' AND p.name = n.name AND p.machine = n.machine \
             AND p.id < n.id AND p.claim <> n.claim AND p.content_hash <> n.content_hash AND p.state IN ('claimed', 'waiting') \
             AND NOT EXISTS (SELECT 1 FROM placement l WHERE l.part_id = p.id)) ORDER BY id",
        );
        let earlier: Vec<PartRow> = match &row.dropped.rewrites {
            Some(claim) if row.terms.order_name.is_empty() => self.parts_of_same_file(claim, new).await?,
            _ => query.bind(new).fetch_all(self.db()).await?,
        };
        let takes_over = TakenOver::of_claim(&row.name, row.ticket.is_some(), earlier.len());
        for old in earlier {
            self.record_revision(&old, new, takes_over).await?;
        }
        Ok(())
    }

    /// What waits of a file that was taken by this claim, and then once more.
    async fn parts_of_same_file(&mut self, claim: &str, new: PartId) -> Result<Vec<PartRow>> {
        let query = sql::select_as(
            "FROM part WHERE (claim = $1 OR id IN (SELECT replaced_by FROM part WHERE claim = $1)) AND id < $2 \
             AND state IN ('claimed', 'waiting') AND NOT EXISTS (SELECT 1 FROM placement l WHERE l.part_id = part.id) ORDER BY id",
        );
        Ok(query.bind(claim).bind(new).fetch_all(self.db()).await?)
    }

    /// Records that a part replaces an earlier revision, and what it takes over of that one.
    async fn record_revision(&mut self, earlier: &PartRow, new: PartId, takes_over: TakenOver) -> Result<()> {
        let old = earlier.id;
        sql::query("UPDATE part SET replaced_by = $1 WHERE id = $2").bind(new).bind(old).execute(self.db()).await?;
        let take = match takes_over {
            TakenOver::Nothing => None,
            TakenOver::Date => Some(
                "UPDATE part SET (customer, material, material_key, due_at, due_text, note) = \
                 (SELECT customer, material, material_key, due_at, due_text, note FROM part WHERE id = $1) \
                 WHERE id = $2 AND state = 'claimed'",
            ),
            TakenOver::All => Some(
                "UPDATE part SET (customer, material, material_key, priority, due_at, due_text, orientation, tilts, clearance_mm, unit, note) = \
                 (SELECT customer, material, material_key, priority, due_at, due_text, orientation, tilts, clearance_mm, unit, note FROM part WHERE id = $1) \
                 WHERE id = $2 AND state = 'claimed'",
            ),
        };
        if let Some(take) = take {
            sql::query(take).bind(old).bind(new).execute(self.db()).await?;
        }
        let is_in_all = takes_over == TakenOver::All && take_copies_over(self, earlier, new).await?;
        let asked = match takes_over {
            TakenOver::Nothing => "",
            TakenOver::Date => ", with its due date and its note",
            TakenOver::All if is_in_all => IN_ALL,
            TakenOver::All => ", with all that was asked with it",
        };
        let detail = format!("it replaces part {old}, an earlier revision{asked}");
        self.write_event(EventKind::Revised, &earlier.machine, Some(new), None, &detail).await
    }

    /// A part that was just claimed takes the place of refused ones of the same name in the same named order: their copies are not
    /// wanted of them any more, so that the order can be complete with those of the new one.
    pub(super) async fn replace_refused_parts(&mut self, new: PartId) -> Result<()> {
        let query = sql::select_as(
            "FROM part WHERE id IN (SELECT p.id FROM part n JOIN part p ON p.order_name = n.order_name \
             WHERE n.id = $1 AND n.state = 'claimed' AND n.order_name <> '' AND p.name = n.name AND p.machine = n.machine \
             AND p.id < n.id AND p.claim <> n.claim AND p.state = 'refused' AND p.replaced_by IS NULL) ORDER BY id",
        );
        let refused: Vec<PartRow> = query.bind(new).fetch_all(self.db()).await?;
        for part in refused {
            let unwanted = i64::from(self.waiting_count(part.id).await?);
            let replace = sql::query("UPDATE part SET replaced_by = $1 WHERE id = $2").bind(new).bind(part.id);
            replace.execute(self.db()).await?;
            self.change_cancelled(part.id, unwanted).await?;
            let detail = format!("part {new} of the same name took its place");
            self.write_event(EventKind::Revised, &part.machine, Some(part.id), None, &detail).await?;
            self.note_wanted_change(-unwanted).await?;
        }
        Ok(())
    }

    /// Whether a claimed part has the number of copies of the revision that it replaces: all of them, however many its file holds.
    pub(super) async fn has_taken_copies_over(&mut self, part: PartId) -> Result<bool> {
        let query =
            "SELECT EXISTS (SELECT 1 FROM event WHERE part_id = $1 AND kind = 'revised' AND detail LIKE '%' || $2)";
        Ok(sql::query_scalar(query).bind(part).bind(IN_ALL).fetch_one(self.db()).await?)
    }
}
