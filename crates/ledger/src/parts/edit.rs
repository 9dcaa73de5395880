//! Changes of what was asked, after the drop: allowed until the final nesting of a copy begins. Each change is an event
//! that names who made it.

use build_file::format_count;

use crate::{
    EventKind, Ledger, LedgerError, PartEdit, PartId, PartRow, PartState, QuestionKind, RefusalCause, UtcTimestamp,
    base::{error::Result, sql},
    store::change::LedgerChange,
};

/// Result of an edit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EditedPart {
    /// What changed, as parts of a sentence: "5 copies instead of 1". Empty = it was so already.
    pub changes: Vec<String>,
}

impl Ledger {
    /// Changes what was asked with a part. A part that is built can be ordered in more copies, for another customer with another address, and with another finish, nothing else.
    pub async fn edit_part(&self, id: PartId, edit: &PartEdit, by: &str) -> Result<EditedPart> {
        let mut change = self.begin_change().await?;
        let edited = edit_part(&mut change, id, edit, by).await?;
        if !edited.changes.is_empty() {
            change.commit().await?;
        }
        Ok(edited)
    }

    /// Takes back waiting copies of a part; at least one copy must remain, waiting or in a build. (All copies of a part
    /// are taken back by [`Ledger::cancel_part`].)
    pub async fn cancel_copies(&self, id: PartId, copies: u32, by: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        let part = change.require_part(id).await?;
        let waiting = change.revocable_count(&part).await?;
        if copies > waiting {
            return Err(LedgerError::TooFewWaiting { part: id, asked: copies, waiting });
        }
        change.end_copies_question(&part).await?;
        take_back(&mut change, &part, copies, by).await?;
        change.count_decision(id).await?;
        change.update_order(&part.terms.order_name).await?;
        change.commit().await
    }

    /// Number of copies of a part that wait for a build, or for their file; 0 if none does.
    pub async fn waiting_copies_of(&self, id: PartId) -> Result<u32> {
        let mut change = self.begin_change().await?;
        let part = change.require_part(id).await?;
        change.revocable_count(&part).await
    }

    /// Moves all parts of a claimed file to another machine, where it is read again; `is_elsewhere` = that is on another node, which must
    /// fetch the file first. Returns the parts.
    pub async fn move_to_machine(
        &self,
        id: PartId,
        machine: &str,
        is_elsewhere: bool,
        by: &str,
    ) -> Result<Vec<PartId>> {
        let mut change = self.begin_change().await?;
        let fetch_at = is_elsewhere.then_some(change.now);
        let claim = change.require_part(id).await?.file.claim;
        let parts: Vec<PartRow> = sql::select_as("FROM part WHERE claim = $1 ORDER BY object_index")
            .bind(&claim)
            .fetch_all(change.db())
            .await?;
        let mut moved = Vec::new();
        for part in parts.iter().filter(|part| matches!(part.state, PartState::Waiting | PartState::Claimed)) {
            ensure_terms_editable(&mut change, part).await?;
            let set = sql::query(
                "UPDATE part SET machine = $1, at_risk_at = NULL, fetch_at = coalesce($3, fetch_at) WHERE id = $2",
            );
            set.bind(machine).bind(part.id).bind(fetch_at).execute(change.db()).await?;
            let detail = format!("{by}: from {} to {machine}", part.machine);
            change.write_event(EventKind::Moved, machine, Some(part.id), None, &detail).await?;
            change.tell_node_of(&part.machine);
            change.count_decision(part.id).await?;
            if part.state == PartState::Waiting {
                change.read_again(part.id, &detail).await?;
            }
            moved.push(part.id);
        }
        match moved.is_empty() {
            true => {
                let state = change.require_part(id).await?.state;
                Err(LedgerError::NotEditable { part: id, state })
            }
            false => change.commit().await.map(|()| moved),
        }
    }

    /// A person confirms that a part is to be printed as it is; where nothing else is asked, in as many copies as it was taken. Returns
    /// whether that was asked.
    pub async fn confirm_part(&self, id: PartId, by: &str) -> Result<bool> {
        let mut change = self.begin_change().await?;
        let part = change.require_part(id).await?;
        if part.owed.question.is_empty() {
            if !QuestionKind::of_part(&part).contains(&QuestionKind::Copies) {
                return Ok(false);
            }
            change.end_copies_question(&part).await?;
            let detail = format!("{by}: {}", as_it_was_taken(part.wanted_copies()));
            change.write_event(EventKind::Confirmed, &part.machine, Some(id), None, &detail).await?;
            change.count_decision(id).await?;
            change.commit().await?;
            return Ok(true);
        }
        let confirm = sql::query("UPDATE part SET question = '' WHERE id = $1").bind(id);
        confirm.execute(change.db()).await?;
        if part.owed.size_differs {
            change.ensure_not_being_built(id).await?;
        }
        change.begin_to_wait_again(&[id]).await?;
        let detail = format!("{by}: {}", part.owed.question);
        change.write_event(EventKind::Confirmed, &part.machine, Some(id), None, &detail).await?;
        change.count_decision(id).await?;
        if part.owed.size_differs {
            change.read_anew(id, &detail).await?;
        }
        change.commit().await?;
        Ok(true)
    }

    /// Parts that wait for a person's yes, oldest first.
    pub async fn parts_in_question(&self) -> Result<Vec<PartRow>> {
        let query = sql::select_as("FROM part WHERE question <> '' AND state = 'waiting' ORDER BY id");
        Ok(query.fetch_all(self.reader()?).await?)
    }
}

/// Changes what was asked with a part, within a change.
pub(crate) async fn edit_part(change: &mut LedgerChange, id: PartId, edit: &PartEdit, by: &str) -> Result<EditedPart> {
    let edit = &edit.clone().checked().map_err(LedgerError::UnusableTerm)?;
    let part = change.require_part(id).await?;
    let mut changes = Vec::new();
    if edit.changes_terms() {
        ensure_terms_editable(change, &part).await?;
        edit_terms(change, &part, edit, &mut changes).await?;
    }
    if let Some(customer) = edit.customer.as_ref().filter(|customer| **customer != part.terms.customer) {
        let set = sql::query("UPDATE part SET customer = $1 WHERE id = $2").bind(customer).bind(id);
        set.execute(change.db()).await?;
        changes.push(difference("customer", &part.terms.customer, customer));
    }
    if let Some(email) = edit.email.as_ref().filter(|email| **email != part.terms.email) {
        let set = sql::query("UPDATE part SET email = $1 WHERE id = $2").bind(email).bind(id);
        set.execute(change.db()).await?;
        changes.push(difference("email", &part.terms.email, email));
    }
    if let Some(finish) = edit.finish.as_ref().filter(|finish| **finish != part.terms.finish) {
        let set = sql::query("UPDATE part SET finish = $1 WHERE id = $2").bind(finish).bind(id);
        set.execute(change.db()).await?;
        change.forget_other_steps(id, finish).await?;
        changes.push(difference("finish", &part.terms.finish, finish));
    }
    if let Some(copies) = edit.copies {
        let was_asked = change.end_copies_question(&part).await?;
        if copies != part.wanted_copies() {
            changes
                .insert(0, format!("{} instead of {}", format_count(copies, "copy", "copies"), part.wanted_copies()));
            edit_copies(change, &part, copies, by).await?;
        } else if was_asked {
            changes.insert(0, as_it_was_taken(copies));
        }
    }
    if changes.is_empty() {
        return Ok(EditedPart { changes });
    }
    let detail = format!("{by}: {}", changes.join(", "));
    change.write_event(EventKind::Edited, &part.machine, Some(id), None, &detail).await?;
    change.count_decision(id).await?;
    if edit.unit.is_some_and(|unit| part.terms.unit != Some(unit)) {
        change.read_anew(id, &detail).await?;
    }
    change.update_order(&part.terms.order_name).await?;
    change.update_customer(&part.terms.order_name).await?;
    if let Some(order) = &edit.order_name {
        change.open_order(order).await?;
        change.update_order(order).await?;
        change.update_customer(order).await?;
    }
    Ok(EditedPart { changes })
}

/// `customer Brandt instead of none`.
fn difference(what: &str, old: &str, new: &str) -> String {
    let none = |text: &str| if text.is_empty() { "none".to_owned() } else { text.to_owned() };
    format!("{what} {} instead of {}", none(new), none(old))
}

fn as_it_was_taken(copies: u32) -> String {
    format!("{}, as it was taken", format_count(copies, "copy", "copies"))
}

/// Terms can change while no copy is being nested and copies wait.
async fn ensure_terms_editable(change: &mut LedgerChange, part: &PartRow) -> Result<()> {
    change.ensure_not_being_built(part.id).await?;
    match part.state {
        PartState::Claimed | PartState::Waiting => Ok(()),
        state => Err(LedgerError::NotEditable { part: part.id, state }),
    }
}

async fn edit_terms(
    change: &mut LedgerChange,
    part: &PartRow,
    edit: &PartEdit,
    changes: &mut Vec<String>,
) -> Result<()> {
    let mut terms = part.terms.clone();
    if let Some(order) = &edit.order_name {
        terms.order_name.clone_from(order);
    }
    if let Some(priority) = edit.priority {
        terms.priority = priority;
    }
    if let Some(due) = &edit.due {
        terms.due_at = due.as_ref().map(|(at, _)| UtcTimestamp(*at));
        terms.due_text = due.as_ref().map(|(_, text)| text.clone()).unwrap_or_default();
    }
    if let Some(rule) = edit.orientation {
        terms.orientation = rule;
    }
    if let Some(tilts) = &edit.tilts {
        terms.tilts.clone_from(tilts);
    }
    if let Some(clearance) = edit.clearance_mm {
        terms.clearance_mm = clearance;
    }
    if let Some(unit) = edit.unit {
        terms.unit = Some(unit);
    }
    if let Some(note) = &edit.note {
        terms.note.clone_from(note);
    }
    if let Some(material) = edit.material.as_ref().filter(|material| **material != terms.material) {
        terms.material.clone_from(material);
        change.set_material(part.id, material).await?;
        change.begin_to_wait_again(&[part.id]).await?;
    }
    changes.extend(describe_changes(&part.terms, &terms));
    sql::query(
        "UPDATE part SET order_name = $1, priority = $2, due_at = $3, due_text = $4, orientation = $5, tilts = $6, \
         clearance_mm = $7, unit = $8, note = $9, at_risk_at = CASE WHEN due_at IS NOT DISTINCT FROM $3 THEN at_risk_at END WHERE id = $10",
    )
    .bind(&terms.order_name)
    .bind(terms.priority)
    .bind(terms.due_at)
    .bind(&terms.due_text)
    .bind(terms.orientation)
    .bind(terms.tilts.to_string())
    .bind(terms.clearance_mm)
    .bind(terms.unit)
    .bind(&terms.note)
    .bind(part.id)
    .execute(change.db())
    .await?;
    Ok(())
}

/// The differences between two sets of terms, as parts of a sentence.
fn describe_changes(old: &crate::PartTerms, new: &crate::PartTerms) -> Vec<String> {
    let due = |terms: &crate::PartTerms| match (&terms.due_text[..], terms.due_at) {
        ("", None) => String::new(),
        ("", Some(at)) => at.to_string(),
        (text, _) => text.to_owned(),
    };
    let unit = |terms: &crate::PartTerms| terms.unit.map_or(String::new(), |unit| format!("{unit:?}").to_lowercase());
    let clearance =
        |terms: &crate::PartTerms| terms.clearance_mm.map_or("the machine's".to_owned(), |mm| format!("{mm} mm"));
    let rule = |terms: &crate::PartTerms| format!("{:?} {}", terms.orientation, terms.tilts).trim().to_lowercase();
    let all = [
        ("order", old.order_name.clone(), new.order_name.clone()),
        ("material", old.material.clone(), new.material.clone()),
        ("priority", old.priority.to_string(), new.priority.to_string()),
        ("due", due(old), due(new)),
        ("orientation", rule(old), rule(new)),
        ("clearance", clearance(old), clearance(new)),
        ("unit", unit(old), unit(new)),
        ("note", old.note.clone(), new.note.clone()),
    ];
    let changed = all.into_iter().filter(|(_, old, new)| old != new);
    changed.map(|(what, old, new)| difference(what, &old, &new)).collect()
}

/// Changes the number of copies wanted. More of a part that is built make it wait again.
async fn edit_copies(change: &mut LedgerChange, part: &PartRow, copies: u32, by: &str) -> Result<()> {
    let placed = change.placed_count(part.id).await?;
    let wanted = part.wanted_copies();
    if copies < placed || copies == 0 {
        return Err(LedgerError::TooManyPlaced { part: part.id, asked: copies, placed });
    }
    if copies < wanted {
        if part.state != PartState::Waiting {
            return Err(LedgerError::NotEditable { part: part.id, state: part.state });
        }
        return take_back(change, part, wanted - copies, by).await;
    }
    if matches!(part.state, PartState::Refused | PartState::Claimed) {
        return Err(LedgerError::NotEditable { part: part.id, state: part.state });
    }
    change.reopen_finishing(part.id).await?;
    let (more, now) = (copies - wanted, change.now);
    let back = more.min(part.owed.cancelled_copies);
    let fetch = (part.state == PartState::Built).then_some(now);
    // Where none waits yet, they wait from now on.
    let since = matches!(part.state, PartState::Built | PartState::Batched).then_some(now);
    sql::query(
        "UPDATE part SET cancelled_copies = cancelled_copies - $1, copies = copies + $2, \
         fetch_at = coalesce(fetch_at, $3), waits_since = coalesce($4, waits_since) WHERE id = $5",
    )
    .bind(back)
    .bind(more - back)
    .bind(fetch)
    .bind(since)
    .bind(part.id)
    .execute(change.db())
    .await?;
    let detail = format!("{more} more wanted by {by}");
    change.write_event(EventKind::CopiesWanted, &part.machine, Some(part.id), None, &detail).await?;
    change.note_wanted_change(i64::from(more)).await?;
    match part.state {
        PartState::Built | PartState::Batched => change.move_part(part.id, PartState::Waiting, None, &detail).await,
        _ => Ok(()),
    }
}

/// Takes back waiting copies.
async fn take_back(change: &mut LedgerChange, part: &PartRow, copies: u32, by: &str) -> Result<()> {
    change.change_cancelled(part.id, i64::from(copies)).await?;
    let detail = format!("{copies} fewer wanted by {by}");
    change.write_event(EventKind::CopiesCancelled, &part.machine, Some(part.id), None, &detail).await?;
    change.note_wanted_change(-i64::from(copies)).await?;
    if part.wanted_copies() == copies {
        return change.refuse_part(part.id, RefusalCause::Cancelled, &format!("Cancelled by {by}.")).await;
    }
    if part.state == PartState::Claimed && change.waiting_count(part.id).await? == 0 {
        change.move_part(part.id, PartState::Waiting, None, "its file is not needed any more").await?;
    }
    change.end_waiting(part.id, None).await
}

impl LedgerChange {
    /// A person says in which size a part is meant: its file is read as if for the first time.
    async fn read_anew(&mut self, id: PartId, why: &str) -> Result<()> {
        let forget = sql::query(
            "UPDATE part SET size_x_mm = NULL, size_y_mm = NULL, size_z_mm = NULL, size_differs = FALSE, mended = '', mended_hash = '', \
             question = CASE WHEN size_differs THEN '' ELSE question END WHERE id = $1",
        );
        forget.bind(id).execute(self.db()).await?;
        match self.require_part(id).await?.state {
            PartState::Waiting => self.read_again(id, why).await,
            _ => Ok(()),
        }
    }

    /// waiting -> claimed: the file is read again, and its attempts of reading are counted anew.
    async fn read_again(&mut self, id: PartId, why: &str) -> Result<()> {
        sql::query("UPDATE part SET reads = 0 WHERE id = $1").bind(id).execute(self.db()).await?;
        self.move_part(id, PartState::Claimed, None, why).await
    }
}
