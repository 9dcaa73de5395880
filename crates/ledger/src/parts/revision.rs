//! Revisions: a file that is dropped again under the same name in the same order replaces what still waits of the earlier one, as does
//! a file that is taken once more because its writer went on.

use crate::{
    EventKind, Ledger, NewPartRow, PartId, PartRow, PartState, RefusalCause, TicketSource,
    base::{error::Result, sql},
    parts::taken_back::copies_lost_by_refusal,
    rows::part_row::{is_missing_file, term_columns},
    store::change::LedgerChange,
};

/// What a file that takes the place of earlier ones takes over of them, unless a ticket came with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TakenOver {
    /// Nothing: it has a ticket.
    Nothing,
    /// The due date and the note: the rest stands in the file itself.
    Date,
    /// All that was asked, but for the copies: those of several parts are not known any more for the file as a whole.
    Terms,
    /// All that was asked.
    All,
}

impl TakenOver {
    /// For a file of this name that takes the place of so many parts.
    fn of_claim(name: &str, has_ticket: bool, replaced: usize) -> Self {
        match replaced {
            _ if has_ticket => Self::Nothing,
            _ if build_file::is_camspec_name(name) => Self::Date,
            1 => Self::All,
            _ => Self::Terms,
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

    /// A part of the same name in the same named order that was moved to another machine and is not built yet: a part that comes now may be a
    /// newer revision of it.
    pub async fn moved_namesake(&self, part: &PartRow) -> Result<Option<PartRow>> {
        let query = sql::select_as(
            "FROM part WHERE name = $1 AND order_name = $2 AND order_name <> '' AND machine <> $3 AND claim <> $4 AND id < $5 \
             AND state IN ('claimed', 'waiting', 'batched') \
             AND EXISTS (SELECT 1 FROM event e WHERE e.part_id = part.id AND e.kind = 'moved') ORDER BY id DESC LIMIT 1",
        );
        let query = query.bind(&part.name).bind(&part.terms.order_name).bind(&part.machine).bind(&part.file.claim);
        Ok(query.bind(part.id).fetch_optional(self.reader()?).await?)
    }

    /// The parts whose place a part took without knowing how many copies are wanted of it: it has no ticket, and they are several, or the
    /// copies of the one were never known. None if that is known.
    pub async fn replaced_without_copies(&self, part: PartId) -> Result<Vec<PartRow>> {
        let query = sql::select_as(
            "FROM part WHERE replaced_by = $1 AND NOT EXISTS (SELECT 1 FROM ticket t WHERE t.part_id = $1) ORDER BY id",
        );
        let replaced: Vec<PartRow> = query.bind(part).fetch_all(self.reader()?).await?;
        let is_unknown = |only: &PartRow| only.refused.refusal == Some(RefusalCause::Ticket);
        Ok(match &replaced[..] {
            [only] if !is_unknown(only) => Vec::new(),
            _ if replaced.iter().any(|one| build_file::is_camspec_name(&one.name)) => Vec::new(),
            _ => replaced,
        })
    }
}

/// Takes over how often the file of a part was wanted. Returns whether that is not known, so that the copies wanted are those in all.
async fn take_copies_over(change: &mut LedgerChange, old: &PartRow, new: PartId) -> Result<bool> {
    let held = sql::query_scalar("SELECT file_copies FROM part WHERE id = $1").bind(old.id);
    let held: Option<u32> = held.fetch_one(change.db()).await?;
    let wanted = change.copies_to_take_over(old).await?;
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
    /// A part that was just claimed takes the place of earlier ones of the same name in the same named order, with what was asked with
    /// them: of refused ones, and, as a revision with other content, of those that wait and have no copy in a build. What was taken of the
    /// same file before needs no order. A file that was put back takes no place: the newer one is there. Returns whether anything was taken
    /// over.
    pub(super) async fn replace_earlier_parts(&mut self, new: PartId, row: &NewPartRow) -> Result<bool> {
        let (refused, revised) = match (&row.dropped.rewrites, row.terms.order_name.is_empty()) {
            (None, true) => return Ok(false),
            (Some(claim), true) => (Vec::new(), self.parts_of_same_file(claim, new).await?),
            (_, false) => self.namesakes_before(new, &row.content_hash).await?,
        };
        if refused.is_empty() && revised.is_empty() || self.find_put_back(new).await?.is_some() {
            return Ok(false);
        }
        let mut wanted: Vec<&PartRow> = Vec::new();
        for part in refused.iter().chain(&revised) {
            if self.copies_to_take_over(part).await? > 0 {
                wanted.push(part);
            }
        }
        // A list counts before the name of a file.
        let is_listed = wanted.iter().any(|part| is_missing_file(&part.file.claim));
        let has_ticket = row.ticket.as_ref().is_some_and(|ticket| !is_listed || ticket.source != TicketSource::Name);
        let takes_over = TakenOver::of_claim(&row.name, has_ticket, wanted.len());
        for old in wanted {
            self.take_over(old, new, takes_over).await?;
        }
        for old in &refused {
            self.settle_refused(old, new).await?;
        }
        for old in &revised {
            sql::query("UPDATE part SET replaced_by = $1 WHERE id = $2")
                .bind(new)
                .bind(old.id)
                .execute(self.db())
                .await?;
        }
        Ok(takes_over != TakenOver::Nothing)
    }

    /// The parts of the same name in the same named order before one that was just claimed: the refused ones and those that never came, and
    /// those that still wait with other content and no copy in a build.
    async fn namesakes_before(&mut self, new: PartId, content_hash: &str) -> Result<(Vec<PartRow>, Vec<PartRow>)> {
        let query = sql::select_as(
            "FROM part WHERE id IN (SELECT p.id FROM part n JOIN part p ON p.order_name = n.order_name \
             WHERE n.id = $1 AND n.state = 'claimed' AND p.name = n.name AND p.machine = n.machine AND p.id < n.id AND p.claim <> n.claim \
             AND (p.state = 'refused' AND p.replaced_by IS NULL OR p.state IN ('claimed', 'waiting') \
             AND NOT EXISTS (SELECT 1 FROM placement l WHERE l.part_id = p.id))) ORDER BY id",
        );
        let found: Vec<PartRow> = query.bind(new).fetch_all(self.db()).await?;
        let (mut refused, mut waiting): (Vec<_>, Vec<_>) =
            found.into_iter().partition(|part| part.state == PartState::Refused);
        refused.retain(|part| !is_missing_file(&part.file.claim));
        refused.extend(self.missing_namesakes(new).await?);
        waiting.retain(|part| part.file.content_hash != content_hash);
        Ok((refused, waiting))
    }

    /// What waits of a file that was taken by this claim, and then once more.
    async fn parts_of_same_file(&mut self, claim: &str, new: PartId) -> Result<Vec<PartRow>> {
        let query = sql::select_as(
            "FROM part WHERE (claim = $1 OR id IN (SELECT replaced_by FROM part WHERE claim = $1)) AND id < $2 \
             AND state IN ('claimed', 'waiting') AND NOT EXISTS (SELECT 1 FROM placement l WHERE l.part_id = part.id) ORDER BY id",
        );
        Ok(query.bind(claim).bind(new).fetch_all(self.db()).await?)
    }

    /// Records that a part takes the place of an earlier one, and what it takes over of that one.
    async fn take_over(&mut self, earlier: &PartRow, new: PartId, takes_over: TakenOver) -> Result<()> {
        let old = earlier.id;
        let take = match takes_over {
            TakenOver::Nothing => None,
            TakenOver::Date => Some(
                "UPDATE part SET (customer, email, material, material_key, finish, due_at, due_text, note) = \
                 (SELECT customer, email, material, material_key, finish, due_at, due_text, note FROM part WHERE id = $1) \
                 WHERE id = $2 AND state = 'claimed'",
            ),
            TakenOver::Terms | TakenOver::All => Some(concat!(
                "UPDATE part SET (",
                term_columns!(),
                ") = (SELECT ",
                term_columns!(),
                " FROM part WHERE id = $1) WHERE id = $2 AND state = 'claimed'",
            )),
        };
        if let Some(take) = take {
            sql::query(take).bind(old).bind(new).execute(self.db()).await?;
        }
        let is_in_all = takes_over == TakenOver::All && take_copies_over(self, earlier, new).await?;
        let asked = match takes_over {
            TakenOver::Nothing => "",
            TakenOver::Date => ", with its due date and its note",
            TakenOver::Terms => ", with all that was asked with it but the copies",
            TakenOver::All if is_in_all => IN_ALL,
            TakenOver::All => ", with all that was asked with it",
        };
        let what = if earlier.state == PartState::Refused { "which was refused" } else { "an earlier revision" };
        let detail = format!("it replaces part {old}, {what}{asked}");
        self.write_event(EventKind::Revised, &earlier.machine, Some(new), None, &detail).await
    }

    /// The copies of a refused part are not wanted of it any more, so that the order can be complete with those of the new one.
    pub(super) async fn settle_refused(&mut self, part: &PartRow, new: PartId) -> Result<()> {
        let unwanted = i64::from(self.waiting_count(part.id).await?);
        let replace = sql::query("UPDATE part SET replaced_by = $1 WHERE id = $2").bind(new).bind(part.id);
        replace.execute(self.db()).await?;
        self.change_cancelled(part.id, unwanted).await?;
        if is_missing_file(&part.file.claim) {
            let reason = format!("Part {new} of the same name took its place.");
            let set = sql::query("UPDATE part SET reason = $1 WHERE id = $2").bind(reason).bind(part.id);
            set.execute(self.db()).await?;
        }
        let detail = format!("part {new} of the same name took its place");
        self.write_event(EventKind::Revised, &part.machine, Some(part.id), None, &detail).await?;
        // What fell when it was cancelled comes back when it is taken back.
        if unwanted > 0 {
            self.note_wanted_change(-unwanted).await?;
        }
        self.update_order(&part.terms.order_name).await
    }

    /// How many copies the file that takes the place of a part is asked for: those wanted of it, and of one that a person cancelled, those
    /// that were wanted until then.
    async fn copies_to_take_over(&mut self, part: &PartRow) -> Result<u32> {
        let lost = match part.refused.refusal {
            Some(RefusalCause::Cancelled) => copies_lost_by_refusal(self, part.id).await?,
            _ => 0,
        };
        Ok(if lost > 0 { lost as u32 } else { part.wanted_copies() })
    }

    /// Whether a claimed part has the number of copies of the revision that it replaces: all of them, however many its file holds.
    pub(super) async fn has_taken_copies_over(&mut self, part: PartId) -> Result<bool> {
        let query =
            "SELECT EXISTS (SELECT 1 FROM event WHERE part_id = $1 AND kind = 'revised' AND detail LIKE '%' || $2)";
        Ok(sql::query_scalar(query).bind(part).bind(IN_ALL).fetch_one(self.db()).await?)
    }
}
