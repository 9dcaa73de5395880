//! The first steps of a part: claimed, read, refused, cancelled, retried.

use build_file::SIZE_WARNING;

use super::{material::material_key, part_size::is_same_size};
use crate::{
    BuildId, EventKind, IllegalMove, Ledger, LedgerError, MEND_BY_SETTING, NewPartRow, NewTicketRow, PartId, PartRow,
    PartState, RecordedAs, RecordedPart, RefusalCause, RequestedTerms, SolidFacts, UtcTimestamp,
    base::{error::Result, sql},
    rows::part_row::term_columns,
    store::change::LedgerChange,
};

impl Ledger {
    /// Records a claim and its ticket. Recording the same claim again returns the same part.
    pub async fn record_claim(&self, part: &NewPartRow) -> Result<RecordedPart> {
        let mut change = self.begin_change().await?;
        let recorded = record_new_part(&mut change, part).await?;
        if recorded.is_new() {
            change.commit().await?;
        }
        Ok(recorded)
    }

    /// Records the claims of many drops in one change, all or none, each with whether it is known what is wanted: then it may be a
    /// revision, or the file of a part that was asked for again. Claims that are already recorded stay unchanged.
    pub async fn record_drops(&self, drops: &[(&NewPartRow, bool)]) -> Result<Vec<RecordedPart>> {
        let mut change = self.begin_change().await?;
        let mut recorded = Vec::with_capacity(drops.len());
        for (part, is_clear) in drops {
            if *is_clear && let Some(id) = change.take_replacement(part, self.node()).await? {
                recorded.push(RecordedPart { id, outcome: RecordedAs::Replacement });
                continue;
            }
            let mut new = record_new_part(&mut change, part).await?;
            if new.outcome == RecordedAs::New && *is_clear && change.replace_earlier_parts(new.id, part).await? {
                new.outcome = RecordedAs::Revision;
            }
            recorded.push(new);
        }
        change.commit().await?;
        Ok(recorded)
    }

    /// Counts another attempt to read the file of a claimed part, and returns the number of attempts. The first attempt
    /// is counted when the claim is recorded, which saves one change of the ledger per file.
    pub async fn begin_read(&self, id: PartId) -> Result<u32> {
        self.add_reads(id, 1).await
    }

    /// Takes back the count of an attempt that failed because of the disk.
    pub async fn uncount_read(&self, id: PartId) -> Result<u32> {
        self.add_reads(id, -1).await
    }

    async fn add_reads(&self, id: PartId, more: i32) -> Result<u32> {
        let mut change = self.begin_change().await?;
        let count =
            "UPDATE part SET reads = CASE WHEN reads + $1 > 0 THEN reads + $1 ELSE 0 END WHERE id = $2 RETURNING reads";
        let reads = sql::query_scalar(count).bind(more).bind(id).fetch_one(change.db()).await?;
        change.commit().await?;
        Ok(reads)
    }

    /// claimed -> waiting: stores the solids that were read. Solids other than 0 become parts of their own. Returns the
    /// parts that wait now. A part of the same file that is not claimed stays unchanged.
    pub async fn accept_solids(&self, id: PartId, solids: &[SolidFacts]) -> Result<Vec<PartId>> {
        let mut change = self.begin_change().await?;
        let claimed = change.require_part(id).await?;
        if claimed.state != PartState::Claimed {
            // Released copies return to waiting too, but a part is read only while it is claimed.
            let (from, to) = (claimed.state.to_string(), PartState::Waiting.to_string());
            return Err(IllegalMove { thing: "part", from, to }.into());
        }
        // All rows come first: each begins with what was asked with the file, and not with what the file asks for another solid.
        let mut parts = Vec::new();
        for solid in solids {
            parts.extend(find_or_insert_solid(&mut change, &claimed, solid).await?.map(|part| (part, solid)));
        }
        let taken_over = match solids {
            [_] => change.has_taken_copies_over(id).await?.then_some(claimed.owed.copies),
            _ => None,
        };
        let mut waiting = Vec::new();
        for (part, solid) in parts {
            let copies = taken_over.unwrap_or(solid.copies);
            write_solid_facts(&mut change, &part, solid, copies).await?;
            let mended = solid.mended.as_ref().map_or("", |mended| mended.text.as_str());
            change.move_known_part(&part, PartState::Waiting, None, mended).await?;
            let is_first = part.measures.triangles.is_none();
            // A part that is read again keeps its copies, which were counted when it was read first.
            if is_first {
                change.note_wanted_change(i64::from(copies)).await?;
            }
            // They may all be in builds by now, or not be wanted any more.
            if !is_first || copies == 0 || part.wanted_copies() < part.owed.copies {
                change.end_waiting(part.id, None).await?;
            }
            waiting.push(part.id);
        }
        if waiting.is_empty() {
            return Err(LedgerError::NoSolid(id));
        }
        change.commit().await?;
        Ok(waiting)
    }

    /// claimed -> refused, together with all claimed solids of the same claim.
    pub async fn refuse_claim(&self, id: PartId, cause: RefusalCause, reason: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        let claimed = change.require_part(id).await?;
        if claimed.state != PartState::Claimed {
            // A waiting part may be refused too, but only by `cancel`, which checks its copies.
            let (from, to) = (claimed.state.to_string(), PartState::Refused.to_string());
            return Err(IllegalMove { thing: "part", from, to }.into());
        }
        let siblings: Vec<PartId> =
            sql::query_scalar("SELECT id FROM part WHERE claim = $1 AND state = 'claimed' ORDER BY id")
                .bind(&claimed.file.claim)
                .fetch_all(change.db())
                .await?;
        for sibling in siblings {
            change.refuse_part(sibling, cause, reason).await?;
        }
        change.commit().await
    }

    /// Checks whether [`Ledger::cancel_part`] would succeed now.
    pub async fn ensure_cancellable(&self, id: PartId) -> Result<()> {
        let mut change = self.begin_change().await?;
        ensure_part_cancellable(&mut change, id).await
    }

    /// waiting -> refused: by an operator, or because the machine changed. Published copies stay published. Fails
    /// while a copy is being nested.
    pub async fn cancel_part(&self, id: PartId, cause: RefusalCause, reason: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        ensure_part_cancellable(&mut change, id).await?;
        change.refuse_part(id, cause, reason).await?;
        change.commit().await
    }

    /// The nesting builds that hold copies of parts of these claims.
    pub async fn nesting_builds_of_claims(&self, claims: &[String]) -> Result<Vec<BuildId>> {
        let query = sql::query_scalar(
            "SELECT DISTINCT b.id FROM build b JOIN placement l ON l.build_id = b.id JOIN part p ON p.id = l.part_id \
             WHERE b.state = 'nesting' AND p.claim IN (SELECT value FROM json_each($1)) ORDER BY b.id",
        );
        Ok(query.bind(serde_json::json!(claims).to_string()).fetch_all(self.reader()?).await?)
    }

    /// claimed, waiting -> refused: another farm has taken these claims over. Returns the parts that were refused
    /// now.
    pub async fn give_up_claims(&self, claims: &[String], reason: &str) -> Result<Vec<PartRow>> {
        let query = sql::select_as(
            "FROM part WHERE state IN ('claimed', 'waiting') \
             AND claim IN (SELECT value FROM json_each($1)) ORDER BY id",
        );
        let parts: Vec<PartRow> = query.bind(serde_json::json!(claims).to_string()).fetch_all(self.reader()?).await?;
        if parts.is_empty() {
            return Ok(parts);
        }
        let mut change = self.begin_change().await?;
        for part in &parts {
            change.refuse_part(part.id, RefusalCause::Cancelled, reason).await?;
        }
        change.commit().await?;
        Ok(parts)
    }
}

async fn ensure_part_cancellable(change: &mut LedgerChange, id: PartId) -> Result<()> {
    change.ensure_not_being_built(id).await?;
    match change.require_part(id).await?.state {
        PartState::Refused => Err(LedgerError::AlreadyRefused(id)),
        PartState::Built => Err(LedgerError::AlreadyBuilt(id)),
        _ => Ok(()),
    }
}

/// Inserts a claim with its ticket and its event, unless it is already recorded.
async fn record_new_part(change: &mut LedgerChange, part: &NewPartRow) -> Result<RecordedPart> {
    let Some(id) = insert_claim(change, part).await? else {
        let known = sql::query_scalar("SELECT id FROM part WHERE claim = $1 AND object_index = 0");
        let id = known.bind(&part.claim).fetch_one(change.db()).await?;
        return Ok(RecordedPart { id, outcome: RecordedAs::Known });
    };
    if let Some(ticket) = &part.ticket {
        let now = change.now;
        insert_ticket(change, id, ticket, now).await?;
    }
    let line = change.take_ordered_line(&part.claim).await?;
    let detail = match &line {
        Some(line) => format!("{}, ordered by {}", part.name, line.client),
        None => part.name.clone(),
    };
    change.write_event(EventKind::Claimed, &part.machine, Some(id), None, &detail).await?;
    change.open_order(&part.terms.order_name).await?;
    if !part.terms.customer.is_empty() {
        change.update_customer(&part.terms.order_name).await?;
    }
    if line.is_some_and(|line| line.is_cancelled) {
        change.refuse_part(id, RefusalCause::Cancelled, "Its line was cancelled before it was taken.").await?;
        return Ok(RecordedPart { id, outcome: RecordedAs::NewAndCancelled });
    }
    Ok(RecordedPart { id, outcome: RecordedAs::New })
}

/// Inserts the row of a claim. `None` if the claim is already recorded.
pub(super) async fn insert_claim(change: &mut LedgerChange, part: &NewPartRow) -> Result<Option<PartId>> {
    let now = change.now;
    let id = sql::query_scalar(
        "INSERT INTO part (claim, machine, name, order_name, content_hash, bytes, state, warnings, copies, priority, \
         due_at, due_text, orientation, tilts, clearance_mm, unit, note, reads, claimed_at, state_at, file_folder, file_mtime_ns, \
         read_unit, customer, material, material_key, email, mend_allowed_by, finish) VALUES ($1, $2, $3, $4, $5, $6, 'claimed', $7, $8, $9, $10, $11, $12, $13, $14, $15, $16, 1, $17, $18, $19, $20, \
         coalesce((SELECT l.read_unit FROM ordered_line l WHERE l.claim = $1), $21), $22, $23, $24, $25, $26, $27) \
         ON CONFLICT (claim, object_index) DO NOTHING RETURNING id",
    )
    .bind(&part.claim)
    .bind(&part.machine)
    .bind(&part.name)
    .bind(&part.terms.order_name)
    .bind(&part.content_hash)
    .bind(part.bytes as i64)
    .bind(merge_lines("", &part.warnings))
    .bind(part.copies)
    .bind(part.terms.priority)
    .bind(part.terms.due_at.map(UtcTimestamp))
    .bind(&part.terms.due_text)
    .bind(part.terms.orientation)
    .bind(part.terms.tilts.to_string())
    .bind(part.terms.clearance_mm)
    .bind(part.terms.unit)
    .bind(&part.terms.note)
    .bind(now)
    .bind(now)
    .bind(&part.dropped.folder)
    .bind(part.dropped.mtime_ns)
    .bind(part.terms.read_unit)
    .bind(&part.terms.customer)
    .bind(&part.terms.material)
    .bind(material_key(&part.terms.material))
    .bind(&part.terms.email)
    .bind(&part.terms.mend_allowed_by)
    .bind(&part.terms.finish)
    .fetch_optional(change.db())
    .await?;
    Ok(id)
}

pub(super) async fn insert_ticket(
    change: &mut LedgerChange,
    part: PartId,
    ticket: &NewTicketRow,
    came_at: UtcTimestamp,
) -> Result<()> {
    sql::query("INSERT INTO ticket (part_id, source, file_name, text, received_at) VALUES ($1, $2, $3, $4, $5)")
        .bind(part)
        .bind(ticket.source)
        .bind(&ticket.file_name)
        .bind(&ticket.text)
        .bind(came_at)
        .execute(change.db())
        .await?;
    Ok(())
}

/// Finds or inserts the row of a solid of the claimed file. `None` if that part is not claimed any more.
async fn find_or_insert_solid(
    change: &mut LedgerChange,
    file: &PartRow,
    solid: &SolidFacts,
) -> Result<Option<PartRow>> {
    if file.solid.object_index == solid.object_index {
        return Ok(Some(file.clone()));
    }
    let known: Option<PartRow> = sql::select_as("FROM part WHERE claim = $1 AND object_index = $2")
        .bind(&file.file.claim)
        .bind(solid.object_index)
        .fetch_optional(change.db())
        .await?;
    if let Some(part) = known {
        return Ok((part.state == PartState::Claimed).then_some(part));
    }
    let now = change.now;
    let id = sql::query_scalar(concat!(
        "INSERT INTO part (claim, object_index, machine, name, order_name, content_hash, bytes, state, warnings, ",
        term_columns!(),
        ", reads, claimed_at, state_at, read_unit, mend_allowed_by) \
             SELECT claim, $1, machine, name, order_name, content_hash, bytes, 'claimed', '', ",
        term_columns!(),
        ", reads, claimed_at, $2, read_unit, mend_allowed_by FROM part WHERE id = $3 RETURNING id"
    ))
    .bind(solid.object_index)
    .bind(now)
    .bind(file.id)
    .fetch_one(change.db())
    .await?;
    change.write_event(EventKind::Claimed, &file.machine, Some(id), None, &solid.object_name).await?;
    Ok(Some(change.require_part(id).await?))
}

/// Stores what was read about a solid. The number of copies is kept if the part was read before, so a retry does not
/// multiply it.
async fn write_solid_facts(change: &mut LedgerChange, part: &PartRow, solid: &SolidFacts, copies: u32) -> Result<()> {
    if let Some(told_mm) = part.size_mm().filter(|told| !is_same_size(*told, solid.size_mm)) {
        return change.hold_other_size(part, told_mm, solid.size_mm, solid.read_unit).await;
    }
    let mended_hash = solid.mended.as_ref().map_or("", |mended| mended.hash.as_str());
    if !part.mending.mended_hash.is_empty() && part.mending.mended_hash != mended_hash {
        return change.hold_other_mending(part).await;
    }
    let [x, y, z] = solid.size_mm;
    sql::query(
        "UPDATE part SET copies = CASE WHEN triangles IS NULL THEN $1 ELSE copies END, object_name = $2, triangles = $3, \
         volume_mm3 = $4, size_x_mm = $5, size_y_mm = $6, size_z_mm = $7, warnings = $8, \
         question = CASE WHEN EXISTS (SELECT 1 FROM event e WHERE e.part_id = part.id AND e.kind = 'confirmed') \
         THEN '' ELSE $9 END, file_copies = $10, read_unit = $11, size_differs = FALSE, mended = $12, mended_hash = $13, \
         mend_allowed_by = CASE WHEN mend_allowed_by = '' AND $13 <> '' THEN $14 ELSE mend_allowed_by END, copy_of = $15 WHERE id = $16",
    )
    .bind(copies)
    .bind(&solid.object_name)
    .bind(solid.triangles as i64)
    .bind(solid.volume_mm3)
    .bind(x)
    .bind(y)
    .bind(z)
    .bind(merge_lines(&without_size_warning(&part.warnings), &solid.warnings))
    .bind(&solid.question)
    .bind(solid.file_copies)
    .bind(solid.read_unit)
    .bind(solid.mended.as_ref().map_or("", |mended| mended.text.as_str()))
    .bind(mended_hash)
    .bind(MEND_BY_SETTING)
    .bind(&solid.copy_of)
    .bind(part.id)
    .execute(change.db())
    .await?;
    match &solid.request {
        Some(request) if part.measures.triangles.is_none() => write_request(change, part, request).await,
        _ => Ok(()),
    }
}

/// Stores what the file of a part asks for it itself.
async fn write_request(change: &mut LedgerChange, part: &PartRow, request: &RequestedTerms) -> Result<()> {
    let terms = part.terms.clone().with_request(request);
    let set = sql::query(
        "UPDATE part SET reference = $1, priority = $2, clearance_mm = $3, orientation = $4, tilts = $5 WHERE id = $6",
    );
    let set = set.bind(&terms.reference).bind(terms.priority).bind(terms.clearance_mm).bind(terms.orientation);
    set.bind(&terms.tilts).bind(part.id).execute(change.db()).await?;
    change.set_material(part.id, &terms.material).await
}

/// The warnings of a part without that of its size, which may have been read in another unit.
fn without_size_warning(warnings: &str) -> String {
    warnings.lines().filter(|line| !line.starts_with(SIZE_WARNING)).collect::<Vec<_>>().join("\n")
}

/// Returns the lines of `known` and those of `more` that are not among them, one per line.
fn merge_lines(known: &str, more: &[String]) -> String {
    let mut all: Vec<String> = known.lines().map(str::to_owned).collect();
    for warning in more {
        let line = warning.replace(['\n', '\r'], " ");
        if !all.contains(&line) {
            all.push(line);
        }
    }
    all.join("\n")
}
