//! A published build on its own: its row, its parts' rows and its placements as one JSON text, which lies beside the originals
//! in the archive. A ledger that was put back from a backup takes in from them what it does not know, so that nothing is
//! printed twice.
//!
//! The text names columns, so that the record of an earlier schema can be taken into a later one.

use serde_json::{Map, Value};

use super::{BuildId, Ledger, LedgerError, PartId, PartState, Utc, change::Change, error::Result};

/// A row as JSON: values by column.
type Row = Map<String, Value>;

/// What became of a record.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TakenIn {
    /// The ledger knew the build already.
    Known,
    /// It is in the ledger now; the sentences say what does not agree with what was there.
    Now(BuildId, Vec<String>),
}

impl Ledger {
    /// The record of a build that is proved or published.
    pub async fn record_of_build(&self, id: BuildId) -> Result<String> {
        let mut snapshot = self.snapshot().await?;
        let mut record = Map::new();
        let of_claims =
            "claim IN (SELECT p.claim FROM part p JOIN placement l ON l.part_id = p.id WHERE l.build_id = ?)";
        let asked =
            [("builds", "build", "id = ?"), ("parts", "part", of_claims), ("placements", "placement", "build_id = ?")];
        for (name, table, which) in asked {
            let columns = columns(&mut snapshot, table).await?;
            let pairs = columns.iter().map(|c| format!("'{c}', {c}")).collect::<Vec<_>>().join(", ");
            let query = format!("SELECT json_object({pairs}) FROM {table} WHERE {which} ORDER BY 1");
            let rows: Vec<String> =
                sqlx::query_scalar(sqlx::AssertSqlSafe(query)).bind(id).fetch_all(&mut *snapshot).await?;
            let rows = rows.iter().map(|row| parse(row)).collect::<Result<Vec<Value>>>()?;
            record.insert(name.to_owned(), rows.into());
        }
        Ok(Value::from(record).to_string())
    }

    /// The row of a part as it stands in a record.
    pub async fn part_for_record(&self, id: PartId) -> Result<Option<Value>> {
        let mut snapshot = self.snapshot().await?;
        let columns = columns(&mut snapshot, "part").await?;
        let pairs = columns.iter().map(|c| format!("'{c}', {c}")).collect::<Vec<_>>().join(", ");
        let query = format!("SELECT json_object({pairs}) FROM part WHERE id = ?");
        let row: Option<String> =
            sqlx::query_scalar(sqlx::AssertSqlSafe(query)).bind(id).fetch_optional(&mut *snapshot).await?;
        row.map(|row| parse(&row)).transpose()
    }

    /// Takes in a build that the ledger does not know; `is_published` = its file has appeared in the queue. Whatever the
    /// ledger planned with its copies is given up: no build that is being nested may hold one.
    pub async fn take_in_record(&self, record: &str, is_published: bool) -> Result<TakenIn> {
        let record = parse(record)?;
        let rows = |name: &str| -> Vec<Row> {
            let rows = record.get(name).and_then(Value::as_array).cloned().unwrap_or_default();
            rows.into_iter().filter_map(|row| row.as_object().cloned()).collect()
        };
        let (builds, parts, placements) = (rows("builds"), rows("parts"), rows("placements"));
        let [build] = &builds[..] else { return Err(broken("it holds no build")) };
        let mut change = self.change().await?;
        if is_known(&mut change, build).await? {
            return Ok(TakenIn::Known);
        }
        let id = take_build(&mut change, build, is_published).await?;
        let mut doubts = Vec::new();
        let mut taken = Vec::new();
        for part in &parts {
            taken.push((number(part, "id")?, take_part(&mut change, part).await?));
        }
        for placement in placements {
            let old = number(&placement, "part_id")?;
            let part = taken.iter().find(|(from, _)| *from == old).map(|(_, part)| *part);
            let part = part.ok_or_else(|| broken("a placement is of no part of it"))?;
            doubts.extend(place(&mut change, id, part, placement).await?);
        }
        let count = "UPDATE build SET copies = (SELECT count(*) FROM placement WHERE build_id = ?1) WHERE id = ?1";
        sqlx::query(count).bind(id).execute(change.db()).await?;
        for (_, part) in taken {
            settle(&mut change, part, id).await?;
        }
        change.commit().await?;
        Ok(TakenIn::Now(id, doubts))
    }

    /// The greatest number of a build that was ever given out, and when the latest build fired.
    pub async fn newest_build(&self) -> Result<(i64, Option<Utc>)> {
        let mut snapshot = self.snapshot().await?;
        let number = "SELECT coalesce((SELECT seq FROM sqlite_sequence WHERE name = 'build'), 0)";
        let number = sqlx::query_scalar(number).fetch_one(&mut *snapshot).await?;
        let fired =
            sqlx::query_scalar("SELECT nesting_at FROM build WHERE nesting_at IS NOT NULL ORDER BY id DESC LIMIT 1");
        Ok((number, fired.fetch_optional(&mut *snapshot).await?))
    }

    /// Whether a part of this number has this content.
    pub async fn is_part_of_content(&self, id: PartId, hash: &str) -> Result<bool> {
        let query = sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM part WHERE id = ? AND content_hash = ?)");
        Ok(query.bind(id).bind(hash).fetch_one(self.reader()?).await?)
    }

    /// Whether the ledger knows a build file of this name.
    pub async fn knows_build_file(&self, file_name: &str) -> Result<bool> {
        let query = sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM build WHERE file_name = ?)");
        Ok(query.bind(file_name).fetch_one(self.reader()?).await?)
    }

    /// Leaves a gap in the numbers of parts and builds: those that were given out after a backup are not given out again.
    pub async fn leave_gap_in_numbers(&self, gap: u32) -> Result<()> {
        let mut change = self.change().await?;
        for table in ["part", "build"] {
            let known = sqlx::query("UPDATE sqlite_sequence SET seq = seq + ? WHERE name = ?").bind(gap).bind(table);
            if known.execute(change.db()).await?.rows_affected() == 0 {
                let insert = sqlx::query("INSERT INTO sqlite_sequence (name, seq) VALUES (?, ?)").bind(table).bind(gap);
                insert.execute(change.db()).await?;
            }
        }
        change.commit().await
    }
}

fn broken(why: &str) -> LedgerError {
    LedgerError::Record(why.to_owned())
}

fn parse(text: &str) -> Result<Value> {
    serde_json::from_str(text).map_err(|error| broken(&error.to_string()))
}

fn number(row: &Row, column: &str) -> Result<i64> {
    row.get(column).and_then(Value::as_i64).ok_or_else(|| broken(&format!("a row has no {column}")))
}

fn word<'a>(row: &'a Row, column: &str) -> &'a str {
    row.get(column).and_then(Value::as_str).unwrap_or_default()
}

async fn columns(db: &mut sqlx::SqliteConnection, table: &str) -> Result<Vec<String>> {
    let query = sqlx::query_scalar("SELECT name FROM pragma_table_info(?) ORDER BY cid");
    Ok(query.bind(table).fetch_all(db).await?)
}

/// The file name tells one build from another; a build that is proved already ends by the daemon's own hand.
async fn is_known(change: &mut Change, build: &Row) -> Result<bool> {
    let query = sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM build WHERE file_name = ?)");
    Ok(query.bind(word(build, "file_name")).fetch_one(change.db()).await?)
}

/// Writes a row with the columns that this schema knows; without `id` it gets a new one. Returns its number.
async fn insert(change: &mut Change, table: &str, row: &Row) -> Result<i64> {
    let known = columns(change.db(), table).await?;
    let known: Vec<&String> = known.iter().filter(|column| row.contains_key(*column)).collect();
    let names = known.iter().map(|c| c.as_str()).collect::<Vec<_>>().join(", ");
    let values = known.iter().map(|c| format!("?1 ->> '$.{c}'")).collect::<Vec<_>>().join(", ");
    let query = format!("INSERT INTO {table} ({names}) VALUES ({values})");
    let json = Value::from(row.clone()).to_string();
    Ok(sqlx::query(sqlx::AssertSqlSafe(query)).bind(json).execute(change.db()).await?.last_insert_rowid())
}

/// Writes these columns of a row over those of the row with this number.
async fn overwrite(change: &mut Change, table: &str, id: i64, row: &Row, keep: &[&str]) -> Result<()> {
    let known = columns(change.db(), table).await?;
    let known = known.iter().filter(|column| row.contains_key(*column) && !keep.contains(&column.as_str()));
    let sets = known.map(|c| format!("{c} = ?1 ->> '$.{c}'")).collect::<Vec<_>>().join(", ");
    let query = format!("UPDATE {table} SET {sets} WHERE id = ?2");
    let json = Value::from(row.clone()).to_string();
    sqlx::query(sqlx::AssertSqlSafe(query)).bind(json).bind(id).execute(change.db()).await?;
    Ok(())
}

async fn is_taken(change: &mut Change, table: &str, id: i64) -> Result<bool> {
    let query = format!("SELECT EXISTS (SELECT 1 FROM {table} WHERE id = ?)");
    Ok(sqlx::query_scalar(sqlx::AssertSqlSafe(query)).bind(id).fetch_one(change.db()).await?)
}

async fn take_build(change: &mut Change, build: &Row, is_published: bool) -> Result<BuildId> {
    let mut row = build.clone();
    let state = if is_published { "published" } else { "verified" };
    row.insert("state".to_owned(), state.into());
    row.insert("layout".to_owned(), Value::Null);
    // When it appeared is not known: it was proved then, and its file appeared at once.
    let at = build.get("verified_at").cloned().unwrap_or_default();
    row.insert("published_at".to_owned(), if is_published { at } else { Value::Null });
    let id = number(build, "id")?;
    let same = "SELECT id FROM build WHERE id = ? AND profile = ? AND opened_at = ? AND state IN ('open', 'nesting') \
                AND NOT EXISTS (SELECT 1 FROM placement l WHERE l.build_id = build.id)";
    let same: Option<i64> = sqlx::query_scalar(same)
        .bind(id)
        .bind(word(build, "profile"))
        .bind(word(build, "opened_at"))
        .fetch_optional(change.db())
        .await?;
    let id = match same {
        // It was still being gathered or nested when the backup was made.
        Some(id) => {
            overwrite(change, "build", id, &row, &["id"]).await?;
            id
        }
        None => {
            if is_taken(change, "build", id).await? {
                row.remove("id");
            }
            insert(change, "build", &row).await?
        }
    };
    let detail = "taken in from its record in the archive";
    change.event(state, word(build, "profile"), None, Some(BuildId(id)), detail).await?;
    Ok(BuildId(id))
}

/// The part of a record in this ledger: a claim is the same file for ever.
async fn take_part(change: &mut Change, part: &Row) -> Result<PartId> {
    let (claim, index) = (word(part, "claim"), number(part, "object_index")?);
    let known: Option<(i64, PartState, i64)> =
        sqlx::query_as("SELECT id, state, decisions FROM part WHERE claim = ? AND object_index = ?")
            .bind(claim)
            .bind(index)
            .fetch_optional(change.db())
            .await?;
    match known {
        Some((id, PartState::Waiting | PartState::Batched | PartState::Built, _)) => Ok(PartId(id)),
        // It was not read yet, or was refused and taken back later.
        Some((id, _, decisions)) => {
            let keep = ["id", "claim", "object_index", "claimed_at"];
            let mut row = part.clone();
            row.insert("state".to_owned(), "waiting".into());
            row.insert("reason".to_owned(), "".into());
            row.insert("refusal".to_owned(), Value::Null);
            // They only grow.
            let more = part.get("decisions").and_then(Value::as_i64).unwrap_or(0);
            row.insert("decisions".to_owned(), decisions.max(more).into());
            overwrite(change, "part", id, &row, &keep).await?;
            Ok(PartId(id))
        }
        None => {
            let mut row = part.clone();
            if word(part, "state") != "rejected" {
                row.insert("state".to_owned(), "waiting".into());
                row.insert("refusal".to_owned(), Value::Null);
            }
            if is_taken(change, "part", number(part, "id")?).await? {
                row.remove("id");
            }
            let id = PartId(insert(change, "part", &row).await?);
            let detail = "taken in from the record of a build";
            change.event("claimed", word(part, "profile"), Some(id), None, detail).await?;
            change.event(word(&row, "state"), word(part, "profile"), Some(id), None, detail).await?;
            Ok(id)
        }
    }
}

/// Puts a copy into its build; what contradicts it is told.
async fn place(change: &mut Change, build: BuildId, part: PartId, mut row: Row) -> Result<Option<String>> {
    let copy = number(&row, "copy")?;
    let holder: Option<(BuildId, Option<String>)> = sqlx::query_as(
        "SELECT b.id, b.published_at FROM placement l JOIN build b ON b.id = l.build_id WHERE l.part_id = ? AND l.copy = ?",
    )
    .bind(part)
    .bind(copy)
    .fetch_optional(change.db())
    .await?;
    if let Some((holder, _)) = holder {
        return Ok(Some(format!("copy {copy} of part {part} is in build {holder} already, and in build {build} too")));
    }
    row.insert("part_id".to_owned(), part.0.into());
    row.insert("build_id".to_owned(), build.0.into());
    insert(change, "placement", &row).await?;
    Ok(None)
}

/// The state of a part by its copies: no move of the state machine, for it was elsewhere when the ledger was put back.
async fn settle(change: &mut Change, part: PartId, build: BuildId) -> Result<()> {
    let row = change.part(part).await?;
    let (placed, open): (u32, u32) = sqlx::query_as(
        "SELECT count(*), coalesce(sum(b.published_at IS NULL), 0) FROM placement l JOIN build b ON b.id = l.build_id \
         WHERE l.part_id = ?",
    )
    .bind(part)
    .fetch_one(change.db())
    .await?;
    let state = match (placed == row.copies, open) {
        (true, 0) => PartState::Built,
        (true, _) => PartState::Batched,
        (false, _) if row.state == PartState::Rejected => PartState::Rejected,
        (false, _) => PartState::Waiting,
    };
    if state == row.state && !matches!(state, PartState::Waiting) {
        return Ok(());
    }
    let now = change.now;
    let set = sqlx::query(
        "UPDATE part SET state = ?1, state_at = ?2, reason = CASE ?1 WHEN 'rejected' THEN reason ELSE '' END, \
         refusal = CASE ?1 WHEN 'rejected' THEN refusal END WHERE id = ?3",
    );
    set.bind(state).bind(now).bind(part).execute(change.db()).await?;
    let detail = "by the record of a build";
    change.event(&state.to_string(), &row.profile, Some(part), Some(build), detail).await
}
