//! The record of a published build: its row, the rows of its parts and its placements as one JSON text. It is stored
//! beside the originals in the archive. A ledger that was restored from a backup imports the builds that it does not
//! know from these records, so nothing is printed twice.
//!
//! The text names the columns, so a record of an earlier schema can be imported into a later one.

use std::collections::BTreeMap;

use build_file::format_count;
use serde_json::{Map, Value};
use sqlx::AssertSqlSafe;

use super::record_rows::{
    JsonRow, asked_and_read, invalid_record, number_column, parse_json, text_column, with_words_of_now,
};
use crate::{
    BuildId, EventKind, Ledger, PartId, PartState, PutBackReport, WITHDRAWN_BY_NESTD,
    base::{
        error::Result,
        sql::{self, SqlTransaction, SqlValue},
    },
    store::change::LedgerChange,
    words::withdrawal::{TAKEN_BACK_SINCE, put_withdrawn_back},
};

/// Result of importing a record.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ImportOutcome {
    /// The ledger already had the build.
    AlreadyKnown,
    /// The build is in the ledger now. The sentences describe conflicts with existing rows.
    Imported(BuildId, Vec<String>),
}

impl Ledger {
    /// Exports the record of a proved or published build.
    pub async fn export_build_record(&self, id: BuildId) -> Result<String> {
        let mut snapshot = self.begin_snapshot().await?;
        let mut record = Map::new();
        let of_claims =
            "claim IN (SELECT p.claim FROM part p JOIN placement l ON l.part_id = p.id WHERE l.build_id = $1)";
        let asked = [
            ("builds", "build", "id = $1"),
            ("parts", "part", of_claims),
            ("placements", "placement", "build_id = $1"),
        ];
        for (name, table, which) in asked {
            let query = format!("SELECT * FROM {table} WHERE {which} ORDER BY 1, 2");
            record.insert(name.to_owned(), read_json_rows(&mut snapshot, query, id.0).await?.into());
        }
        Ok(Value::from(record).to_string())
    }

    /// Exports the row of a part in the format of a record.
    pub async fn export_part_row(&self, id: PartId) -> Result<Option<Value>> {
        let mut snapshot = self.begin_snapshot().await?;
        let query = "SELECT * FROM part WHERE id = $1".to_owned();
        Ok(read_json_rows(&mut snapshot, query, id.0).await?.pop())
    }

    /// Imports a build that the ledger does not know. `is_published` = its file has appeared in the queue. Anything
    /// that the ledger planned for its copies must be given up before: no nesting build may hold one of them.
    pub async fn import_build_record(&self, record: &str, is_published: bool) -> Result<ImportOutcome> {
        let record = parse_json(record)?;
        let rows = |name: &str| -> Vec<JsonRow> {
            let rows = record.get(name).and_then(Value::as_array).cloned().unwrap_or_default();
            rows.into_iter().filter_map(|row| row.as_object().cloned()).map(with_words_of_now).collect()
        };
        let (builds, parts, placements) = (rows("builds"), rows("parts"), rows("placements"));
        let [build] = &builds[..] else { return Err(invalid_record("it holds no build")) };
        let mut change = self.begin_change().await?;
        if is_known_build(&mut change, build).await? {
            return Ok(ImportOutcome::AlreadyKnown);
        }
        let id = import_build(&mut change, build, is_published).await?;
        let (mut doubts, mut again) = (Vec::new(), BTreeMap::<BuildId, u32>::new());
        let mut taken = Vec::new();
        for part in &parts {
            taken.push((number_column(part, "id")?, import_part(&mut change, part).await?));
        }
        for placement in placements {
            let old = number_column(&placement, "part_id")?;
            let part = taken.iter().find(|(from, _)| *from == old).map(|(_, part)| *part);
            let part = part.ok_or_else(|| invalid_record("a placement refers to a part that it does not hold"))?;
            match import_placement(&mut change, id, part, placement).await? {
                ImportedCopy::Placed => {}
                ImportedCopy::Again(before) => *again.entry(before).or_default() += 1,
                ImportedCopy::Conflict(sentence) => doubts.push(sentence),
            }
        }
        doubts.extend(again.into_iter().map(|(before, number)| {
            let (copies, count) = (format_count(number, "copy", "copies"), if number == 1 { "counts" } else { "count" });
            format!("{copies} of build {before} {count} as bad: build {id} was made of the same ones later. Tell how both prints ended")
        }));
        let count = "UPDATE build SET copies = (SELECT count(*) FROM placement WHERE build_id = $1) WHERE id = $1";
        sql::query(count).bind(id).execute(change.db()).await?;
        for ((_, part), row) in taken.into_iter().zip(&parts) {
            take_over_copies(&mut change, part, row).await?;
            update_part_state(&mut change, part, id).await?;
        }
        if is_published && build.get("withdrawn_at").is_some_and(Value::is_string) {
            put_withdrawn_back(&mut change, id, WITHDRAWN_BY_NESTD, TAKEN_BACK_SINCE).await?;
        }
        change.commit().await?;
        Ok(ImportOutcome::Imported(id, doubts))
    }

    /// Whether the part with this number has this content.
    pub async fn part_has_content(&self, id: PartId, hash: &str) -> Result<bool> {
        let query = sql::query_scalar("SELECT EXISTS (SELECT 1 FROM part WHERE id = $1 AND content_hash = $2)");
        Ok(query.bind(id).bind(hash).fetch_one(self.reader()?).await?)
    }

    /// Whether the ledger knows a build file of this name.
    pub async fn has_build_file(&self, file_name: &str) -> Result<bool> {
        let query = sql::query_scalar("SELECT EXISTS (SELECT 1 FROM build WHERE file_name = $1)");
        Ok(query.bind(file_name).fetch_one(self.reader()?).await?)
    }

    /// Leaves a gap in the numbers of parts and builds, so numbers used after the backup was made are not used again.
    pub async fn leave_gap_in_numbers(&self, gap: u32) -> Result<()> {
        let mut change = self.begin_change().await?;
        for table in ["part", "build"] {
            sql::skip_numbers(change.db(), table, gap).await?;
        }
        change.commit().await
    }
}

/// Reads rows as JSON.
async fn read_json_rows(db: &mut SqlTransaction, query: String, id: i64) -> Result<Vec<Value>> {
    let rows: Vec<Vec<(String, SqlValue)>> = sql::query_whole_rows(AssertSqlSafe(query)).bind(id).fetch_all(db).await?;
    Ok(rows.into_iter().map(|row| row.into_iter().map(|(name, value)| (name, value.into_json())).collect()).collect())
}

/// Builds are identified by their file names. A build that was already proved is finished by the daemon itself.
async fn is_known_build(change: &mut LedgerChange, build: &JsonRow) -> Result<bool> {
    let query = sql::query_scalar("SELECT EXISTS (SELECT 1 FROM build WHERE file_name = $1)");
    Ok(query.bind(text_column(build, "file_name")).fetch_one(change.db()).await?)
}

/// Inserts a row with the columns that this schema knows. Without `id`, it gets a new one. Returns the value of its
/// first column that is a number: its number, where it has one.
async fn insert_row(change: &mut LedgerChange, table: &str, row: &JsonRow) -> Result<i64> {
    let known = sql::table_columns(change.db(), table).await?;
    let given: Vec<(&String, &Value)> =
        known.iter().filter_map(|column| Some((column, row.get(column).filter(|value| !value.is_null())?))).collect();
    let names = given.iter().map(|(column, _)| column.as_str()).collect::<Vec<_>>().join(", ");
    let values = (1..=given.len()).map(|n| format!("${n}")).collect::<Vec<_>>().join(", ");
    let query = format!("INSERT INTO {table} ({names}) VALUES ({values}) RETURNING {}", known[0]);
    let insert = given.iter().fold(sql::query_scalar(AssertSqlSafe(query)), |query, (_, value)| query.bind(*value));
    let first = insert.fetch_one(change.db()).await?;
    if row.contains_key("id") {
        sql::number_from_highest(change.db(), table).await?;
    }
    Ok(first)
}

/// Overwrites the columns of an existing row with the values of `row`, except the columns in `keep`.
async fn overwrite_row(change: &mut LedgerChange, table: &str, id: i64, row: &JsonRow, keep: &[&str]) -> Result<()> {
    let known = sql::table_columns(change.db(), table).await?;
    let known = known.iter().filter(|column| row.contains_key(*column) && !keep.contains(&column.as_str()));
    let (mut sets, mut values) = (Vec::new(), Vec::new());
    for column in known {
        match &row[column] {
            Value::Null => sets.push(format!("{column} = NULL")),
            value => {
                values.push(value);
                sets.push(format!("{column} = ${}", values.len() + 1));
            }
        }
    }
    let query = format!("UPDATE {table} SET {} WHERE id = $1", sets.join(", "));
    let update = values.into_iter().fold(sql::query(AssertSqlSafe(query)).bind(id), |query, value| query.bind(value));
    update.execute(change.db()).await?;
    Ok(())
}

async fn is_id_taken(change: &mut LedgerChange, table: &str, id: i64) -> Result<bool> {
    let query = format!("SELECT EXISTS (SELECT 1 FROM {table} WHERE id = $1)");
    Ok(sql::query_scalar(AssertSqlSafe(query)).bind(id).fetch_one(change.db()).await?)
}

async fn import_build(change: &mut LedgerChange, build: &JsonRow, is_published: bool) -> Result<BuildId> {
    let mut row = build.clone();
    let state = if is_published { "published" } else { "verified" };
    row.insert("state".to_owned(), state.into());
    row.insert("layout".to_owned(), Value::Null);
    row.insert("withdrawn_at".to_owned(), Value::Null);
    // The time of publication is unknown. The time of the proof is used, because the file appeared right afterwards.
    let at = build.get("verified_at").cloned().unwrap_or_default();
    row.insert("published_at".to_owned(), if is_published { at } else { Value::Null });
    let id = number_column(build, "id")?;
    let same = "SELECT id FROM build WHERE id = $1 AND machine = $2 AND opened_at = $3 AND state IN ('open', 'nesting') \
                AND NOT EXISTS (SELECT 1 FROM placement l WHERE l.build_id = build.id)";
    let same: Option<i64> = sql::query_scalar(same)
        .bind(id)
        .bind(text_column(build, "machine"))
        .bind(text_column(build, "opened_at"))
        .fetch_optional(change.db())
        .await?;
    let id = match same {
        // The build was still open or nesting when the backup was made.
        Some(id) => {
            overwrite_row(change, "build", id, &row, &["id"]).await?;
            id
        }
        None => {
            if is_id_taken(change, "build", id).await? {
                row.remove("id");
            }
            insert_row(change, "build", &row).await?
        }
    };
    let detail = "imported from its record in the archive";
    change
        .write_event(EventKind::from_word(state), text_column(build, "machine"), None, Some(BuildId(id)), detail)
        .await?;
    Ok(BuildId(id))
}

/// Finds or imports a part of a record. A claim always means the same file.
async fn import_part(change: &mut LedgerChange, part: &JsonRow) -> Result<PartId> {
    let (claim, index) = (text_column(part, "claim"), number_column(part, "object_index")?);
    let known: Option<(i64, PartState, i64)> =
        sql::query_as("SELECT id, state, decisions FROM part WHERE claim = $1 AND object_index = $2")
            .bind(claim)
            .bind(index)
            .fetch_optional(change.db())
            .await?;
    match known {
        Some((id, PartState::Waiting | PartState::Batched | PartState::Built, _)) => {
            // The record is newer than the ledger: what was asked for and read then is what was printed.
            change.open_order(text_column(part, "order_name")).await?;
            overwrite_row(change, "part", id, &asked_and_read(part), &[]).await?;
            Ok(PartId(id))
        }
        // The part was not read yet, or was refused and retried later.
        Some((id, _, decisions)) => {
            let keep = ["id", "claim", "object_index", "claimed_at"];
            let mut row = part.clone();
            row.insert("state".to_owned(), "waiting".into());
            row.insert("reason".to_owned(), "".into());
            row.insert("refusal".to_owned(), Value::Null);
            // The number of decisions never decreases.
            let more = part.get("decisions").and_then(Value::as_i64).unwrap_or(0);
            row.insert("decisions".to_owned(), decisions.max(more).into());
            overwrite_row(change, "part", id, &row, &keep).await?;
            Ok(PartId(id))
        }
        None => {
            let mut row = part.clone();
            if text_column(part, "state") != "refused" {
                row.insert("state".to_owned(), "waiting".into());
                row.insert("refusal".to_owned(), Value::Null);
            }
            if is_id_taken(change, "part", number_column(part, "id")?).await? {
                row.remove("id");
            }
            let id = PartId(insert_row(change, "part", &row).await?);
            change.open_order(text_column(part, "order_name")).await?;
            let detail = "imported from the record of a build";
            change.write_event(EventKind::Claimed, text_column(part, "machine"), Some(id), None, detail).await?;
            change
                .write_event(
                    EventKind::from_word(text_column(&row, "state")),
                    text_column(part, "machine"),
                    Some(id),
                    None,
                    detail,
                )
                .await?;
            Ok(id)
        }
    }
}

/// What became of a copy of a record.
enum ImportedCopy {
    Placed,
    /// It was printed in this build before, and told bad after the ledger was written: nothing else puts it into a later build.
    Again(BuildId),
    /// Another build has it; a sentence.
    Conflict(String),
}

/// Inserts a copy into its build.
async fn import_placement(
    change: &mut LedgerChange,
    build: BuildId,
    part: PartId,
    mut row: JsonRow,
) -> Result<ImportedCopy> {
    let copy = number_column(&row, "copy")?;
    let holder: Option<(BuildId, bool)> = sql::query_as(
        "SELECT b.id, coalesce(b.published_at < n.published_at, FALSE) FROM placement l JOIN build b ON b.id = l.build_id \
         JOIN build n ON n.id = $3 WHERE l.part_id = $1 AND l.copy = $2",
    )
    .bind(part)
    .bind(copy)
    .bind(build)
    .fetch_optional(change.db())
    .await?;
    let mut imported = ImportedCopy::Placed;
    if let Some((holder, is_later)) = holder {
        let (true, Ok(number)) = (is_later, u32::try_from(copy)) else {
            let sentence = format!("copy {copy} of part {part} is in build {holder} already, and in build {build} too");
            return Ok(ImportedCopy::Conflict(sentence));
        };
        let by = LedgerChange::TOLD_BY_RECORD;
        change.mark_bad(holder, &[(part, number)], by, true, &mut PutBackReport::default()).await?;
        imported = ImportedCopy::Again(holder);
    }
    row.insert("part_id".to_owned(), part.0.into());
    row.insert("build_id".to_owned(), build.0.into());
    insert_row(change, "placement", &row).await?;
    Ok(imported)
}

/// How many copies are wanted may have been changed after the ledger was written: the record says it if it counts more decisions. In any
/// case, at least as many are wanted as stand in builds. The events tell the difference.
async fn take_over_copies(change: &mut LedgerChange, part: PartId, record: &JsonRow) -> Result<()> {
    let row = change.require_part(part).await?;
    let (placed, numbers): (i64, i64) =
        sql::query_as("SELECT count(*), coalesce(max(copy) + 1, 0) FROM placement WHERE part_id = $1")
            .bind(part)
            .fetch_one(change.db())
            .await?;
    let (mut copies, mut wanted) = (i64::from(row.owed.copies), i64::from(row.wanted_copies()));
    let known = sql::query_scalar::<i64>("SELECT decisions FROM part WHERE id = $1").bind(part);
    let decisions = record.get("decisions").and_then(Value::as_i64).unwrap_or(0);
    if decisions > known.fetch_one(change.db()).await? {
        let then = number_column(record, "copies")?;
        let cancelled = record.get("cancelled_copies").and_then(Value::as_i64).unwrap_or(0);
        (copies, wanted) = (copies.max(then), then - cancelled);
    }
    (copies, wanted) = (copies.max(numbers), wanted.max(placed));
    let set = sql::query(
        "UPDATE part SET copies = $1, cancelled_copies = $1 - $2, decisions = CASE WHEN decisions < $3 THEN $3 ELSE decisions END WHERE id = $4",
    );
    set.bind(copies).bind(wanted).bind(decisions).bind(part).execute(change.db()).await?;
    let told: Option<i64> = sql::query_scalar(
        "SELECT CAST(sum(wanted_change) AS BIGINT) FROM event WHERE part_id = $1 \
         AND EXISTS (SELECT 1 FROM event w WHERE w.part_id = $1 AND w.kind = 'waiting' AND w.wanted_change IS NOT NULL)",
    )
    .bind(part)
    .fetch_one(change.db())
    .await?;
    let Some(more) = told.map(|told| wanted - told).filter(|more| *more != 0) else { return Ok(()) };
    let (kind, what) = match more > 0 {
        true => (EventKind::CopiesWanted, "more"),
        false => (EventKind::CopiesCancelled, "fewer"),
    };
    let detail = format!("{} {what} wanted, according to the record of a build", more.abs());
    change.write_event(kind, &row.machine, Some(part), None, &detail).await?;
    change.note_wanted_change(more).await
}

/// Sets the state of a part according to its copies. This bypasses the state machine, because the part made its
/// transitions in another ledger.
async fn update_part_state(change: &mut LedgerChange, part: PartId, build: BuildId) -> Result<()> {
    let row = change.require_part(part).await?;
    let (placed, open): (u32, u32) = sql::query_as(
        "SELECT count(*), count(*) FILTER (WHERE b.published_at IS NULL) FROM placement l JOIN build b ON b.id = l.build_id \
         WHERE l.part_id = $1",
    )
    .bind(part)
    .fetch_one(change.db())
    .await?;
    let state = match (placed == row.wanted_copies(), open) {
        (true, 0) => PartState::Built,
        (true, _) => PartState::Batched,
        (false, _) if row.state == PartState::Refused => PartState::Refused,
        (false, _) => PartState::Waiting,
    };
    if state == row.state && !matches!(state, PartState::Waiting) {
        return Ok(());
    }
    let now = change.now;
    let set = sql::query(
        "UPDATE part SET state = $1, state_at = $2, reason = CASE $1 WHEN 'refused' THEN reason ELSE '' END, \
         refusal = CASE $1 WHEN 'refused' THEN refusal END, \
         put_back_at = CASE $1 WHEN 'built' THEN NULL ELSE put_back_at END, \
         fetch_at = CASE $1 WHEN 'built' THEN NULL ELSE fetch_at END WHERE id = $3",
    );
    set.bind(state).bind(now).bind(part).execute(change.db()).await?;
    change.decide_awaiting(part).await?;
    let detail = "according to the record of a build";
    change.write_event(state, &row.machine, Some(part), Some(build), detail).await
}
