//! The first steps of a part's life: claimed, read, refused, cancelled, taken back.

use super::{
    BuildId, BuildState, IllegalMove, Ledger, LedgerError, NewPart, NewTicket, PartId, PartRow, PartState, Recorded,
    Refusal, SolidFacts, Utc, change::Change, error::Result, word::Word,
};

impl Ledger {
    /// Records a claim and its ticket; the same claim again gives the same part.
    pub async fn record_claim(&self, part: &NewPart) -> Result<Recorded> {
        let mut change = self.change().await?;
        let recorded = record(&mut change, part).await?;
        if recorded.fresh {
            change.commit().await?;
        }
        Ok(recorded)
    }

    /// Records many claims in one change, all or none; those that are known stay as they are.
    pub async fn record_claims(&self, parts: &[&NewPart]) -> Result<Vec<Recorded>> {
        let mut change = self.change().await?;
        let mut recorded = Vec::with_capacity(parts.len());
        for part in parts {
            recorded.push(record(&mut change, part).await?);
        }
        change.commit().await?;
        Ok(recorded)
    }

    /// Counts a further attempt to read a claimed part's file; returns how many there are now. The first is counted with the
    /// claim, which saves a change of the ledger for each file.
    pub async fn begin_read(&self, id: PartId) -> Result<u32> {
        self.count_read(id, 1).await
    }

    /// An attempt that the disk hindered does not count.
    pub async fn forget_read(&self, id: PartId) -> Result<u32> {
        self.count_read(id, -1).await
    }

    async fn count_read(&self, id: PartId, more: i32) -> Result<u32> {
        let mut change = self.change().await?;
        let count = "UPDATE part SET reads = max(reads + ?, 0) WHERE id = ? RETURNING reads";
        let reads = sqlx::query_scalar(count).bind(more).bind(id).fetch_one(change.db()).await?;
        change.commit().await?;
        Ok(reads)
    }

    /// claimed -> waiting: the solids that were read; further solids than 0 become parts of their own. Returns the
    /// parts that wait now. A sibling that is not claimed stays as it is.
    pub async fn accept(&self, id: PartId, solids: &[SolidFacts]) -> Result<Vec<PartId>> {
        let mut change = self.change().await?;
        let claimed = change.part(id).await?;
        if claimed.state != PartState::Claimed {
            // Copies that are let go wait again too, but a part is read only when it is claimed.
            let (from, to) = (claimed.state.to_string(), PartState::Waiting.to_string());
            return Err(IllegalMove { thing: "part", from, to }.into());
        }
        let mut waiting = Vec::new();
        for solid in solids {
            if let Some(part) = claimed_solid(&mut change, &claimed, solid).await? {
                write_facts(&mut change, &part, solid).await?;
                change.move_part(part.id, PartState::Waiting, None, "").await?;
                waiting.push(part.id);
            }
        }
        if waiting.is_empty() {
            return Err(LedgerError::NoSolid(id));
        }
        change.commit().await?;
        Ok(waiting)
    }

    /// claimed -> rejected, with all claimed solids of the same claim.
    pub async fn reject(&self, id: PartId, cause: Refusal, reason: &str) -> Result<()> {
        let mut change = self.change().await?;
        let claimed = change.part(id).await?;
        if claimed.state != PartState::Claimed {
            // A waiting part may be rejected too, but only by `cancel`, which looks at its copies.
            let (from, to) = (claimed.state.to_string(), PartState::Rejected.to_string());
            return Err(IllegalMove { thing: "part", from, to }.into());
        }
        let siblings: Vec<PartId> =
            sqlx::query_scalar("SELECT id FROM part WHERE claim = ? AND state = 'claimed' ORDER BY id")
                .bind(&claimed.file.claim)
                .fetch_all(change.db())
                .await?;
        for sibling in siblings {
            change.reject_part(sibling, cause, reason).await?;
        }
        change.commit().await
    }

    /// Whether [`Ledger::cancel`] would do it now.
    pub async fn demand_cancellable(&self, id: PartId) -> Result<()> {
        let mut change = self.change().await?;
        demand_cancellable(&mut change, id).await
    }

    /// waiting -> rejected: by an operator, or because the profile changed. Published copies stay published; refused
    /// while a copy is being nested.
    pub async fn cancel(&self, id: PartId, cause: Refusal, reason: &str) -> Result<()> {
        let mut change = self.change().await?;
        demand_cancellable(&mut change, id).await?;
        change.reject_part(id, cause, reason).await?;
        change.commit().await
    }

    /// The builds in work that hold copies of parts of these claims.
    pub async fn nesting_builds_of_claims(&self, claims: &[String]) -> Result<Vec<BuildId>> {
        let query = sqlx::query_scalar(
            "SELECT DISTINCT b.id FROM build b JOIN placement l ON l.build_id = b.id JOIN part p ON p.id = l.part_id \
             WHERE b.state = 'nesting' AND p.claim IN (SELECT value FROM json_each(?)) ORDER BY b.id",
        );
        Ok(query.bind(serde_json::json!(claims).to_string()).fetch_all(self.reader()?).await?)
    }

    /// claimed, waiting -> rejected: another farm has taken these claims over. Returns the parts that were given up now.
    pub async fn give_up_claims(&self, claims: &[String], reason: &str) -> Result<Vec<PartRow>> {
        let query = sqlx::query_as(
            "SELECT * FROM part WHERE state IN ('claimed', 'waiting') \
             AND claim IN (SELECT value FROM json_each(?)) ORDER BY id",
        );
        let parts: Vec<PartRow> = query.bind(serde_json::json!(claims).to_string()).fetch_all(self.reader()?).await?;
        if parts.is_empty() {
            return Ok(parts);
        }
        let mut change = self.change().await?;
        for part in &parts {
            change.reject_part(part.id, Refusal::Cancelled, reason).await?;
        }
        change.commit().await?;
        Ok(parts)
    }

    /// rejected -> claimed: it is read again.
    pub async fn retry(&self, id: PartId) -> Result<()> {
        let mut change = self.change().await?;
        let state = change.part(id).await?.state;
        if state != PartState::Rejected {
            return Err(LedgerError::NotRejected { part: id, state });
        }
        change.move_part(id, PartState::Claimed, None, "taken back").await?;
        change.count_decision(id).await?;
        change.commit().await
    }
}

async fn demand_cancellable(change: &mut Change, id: PartId) -> Result<()> {
    let nested: Option<(BuildId, BuildState)> = sqlx::query_as(
        "SELECT b.id, b.state FROM placement l JOIN build b ON b.id = l.build_id \
         WHERE l.part_id = ? AND b.published_at IS NULL LIMIT 1",
    )
    .bind(id)
    .fetch_optional(change.db())
    .await?;
    if let Some((build, state)) = nested {
        return Err(LedgerError::BeingBuilt { part: id, build, state });
    }
    match change.part(id).await?.state {
        PartState::Rejected => Err(LedgerError::IsOut(id)),
        PartState::Built => Err(LedgerError::IsBuilt(id)),
        _ => Ok(()),
    }
}

/// A claim with its ticket and its event, unless it is recorded already.
async fn record(change: &mut Change, part: &NewPart) -> Result<Recorded> {
    let Some(id) = insert_claim(change, part).await? else {
        let known = sqlx::query_scalar("SELECT id FROM part WHERE claim = ? AND object_index = 0");
        let id = known.bind(&part.claim).fetch_one(change.db()).await?;
        return Ok(Recorded { id, fresh: false });
    };
    if let Some(ticket) = &part.ticket {
        insert_ticket(change, id, ticket).await?;
    }
    change.event("claimed", &part.profile, Some(id), None, &part.name).await?;
    Ok(Recorded { id, fresh: true })
}

/// `None` when the claim is recorded already.
async fn insert_claim(change: &mut Change, part: &NewPart) -> Result<Option<PartId>> {
    let now = change.now;
    let id = sqlx::query_scalar(
        "INSERT INTO part (claim, profile, name, order_name, content_hash, bytes, state, warnings, copies, priority, \
         due_at, orientation, tilts, clearance_mm, unit, note, reads, claimed_at, state_at) \
         VALUES (?, ?, ?, ?, ?, ?, 'claimed', ?, ?, ?, ?, ?, ?, ?, ?, ?, 1, ?, ?) \
         ON CONFLICT (claim, object_index) DO NOTHING RETURNING id",
    )
    .bind(&part.claim)
    .bind(&part.profile)
    .bind(&part.name)
    .bind(&part.terms.order_name)
    .bind(&part.content_hash)
    .bind(part.bytes as i64)
    .bind(lines("", &part.warnings))
    .bind(part.copies)
    .bind(part.terms.priority)
    .bind(part.terms.due_at.map(Utc))
    .bind(Word(part.terms.orientation))
    .bind(part.terms.tilts.to_string())
    .bind(part.terms.clearance_mm)
    .bind(Word(part.terms.unit))
    .bind(&part.terms.note)
    .bind(now)
    .bind(now)
    .fetch_optional(change.db())
    .await?;
    Ok(id)
}

async fn insert_ticket(change: &mut Change, part: PartId, ticket: &NewTicket) -> Result<()> {
    let now = change.now;
    sqlx::query("INSERT INTO ticket (part_id, source, file_name, text, received_at) VALUES (?, ?, ?, ?, ?)")
        .bind(part)
        .bind(ticket.source)
        .bind(&ticket.file_name)
        .bind(&ticket.text)
        .bind(now)
        .execute(change.db())
        .await?;
    Ok(())
}

/// The row of a solid of the claimed file, made when there is none; `None` when it is not claimed any more.
async fn claimed_solid(change: &mut Change, file: &PartRow, solid: &SolidFacts) -> Result<Option<PartRow>> {
    let known: Option<PartRow> = sqlx::query_as("SELECT * FROM part WHERE claim = ? AND object_index = ?")
        .bind(&file.file.claim)
        .bind(solid.object_index)
        .fetch_optional(change.db())
        .await?;
    if let Some(part) = known {
        return Ok((part.state == PartState::Claimed).then_some(part));
    }
    let now = change.now;
    let id = sqlx::query_scalar(
        "INSERT INTO part (claim, object_index, profile, name, order_name, content_hash, bytes, state, warnings, \
         priority, due_at, orientation, tilts, clearance_mm, unit, note, reads, claimed_at, state_at) \
         SELECT claim, ?, profile, name, order_name, content_hash, bytes, 'claimed', '', \
         priority, due_at, orientation, tilts, clearance_mm, unit, note, reads, claimed_at, ? FROM part WHERE id = ? RETURNING id",
    )
    .bind(solid.object_index)
    .bind(now)
    .bind(file.id)
    .fetch_one(change.db())
    .await?;
    change.event("claimed", &file.profile, Some(id), None, &solid.object_name).await?;
    Ok(Some(change.part(id).await?))
}

/// Copies are kept when the part was read before: asking again must not multiply them.
async fn write_facts(change: &mut Change, part: &PartRow, solid: &SolidFacts) -> Result<()> {
    let [x, y, z] = solid.size_mm;
    sqlx::query(
        "UPDATE part SET copies = CASE WHEN triangles IS NULL THEN ? ELSE copies END, object_name = ?, triangles = ?, \
         volume_mm3 = ?, size_x_mm = ?, size_y_mm = ?, size_z_mm = ?, warnings = ? WHERE id = ?",
    )
    .bind(solid.copies)
    .bind(&solid.object_name)
    .bind(solid.triangles as i64)
    .bind(solid.volume_mm3)
    .bind(x)
    .bind(y)
    .bind(z)
    .bind(lines(&part.warnings, &solid.warnings))
    .bind(part.id)
    .execute(change.db())
    .await?;
    Ok(())
}

/// `known` and those of `more` that are not in it, one per line.
fn lines(known: &str, more: &[String]) -> String {
    let mut all: Vec<String> = known.lines().map(str::to_owned).collect();
    for warning in more {
        let line = warning.replace(['\n', '\r'], " ");
        if !all.contains(&line) {
            all.push(line);
        }
    }
    all.join("\n")
}
