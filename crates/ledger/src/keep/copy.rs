//! Copies a ledger into another one, between a file and a server or back: all rows with their numbers, in one transaction, which
//! is committed only if all tables and views of both hold the same.

use std::collections::{BTreeMap, BTreeSet};

use sqlx::AssertSqlSafe;
use thiserror::Error;

use crate::{
    Ledger, LedgerError,
    base::sql::{self, ColumnHolds, DynamicRow, SqlTransaction, SqlValue},
};

/// A table, in an order in which no row refers to one that is not there yet.
pub(crate) struct CopiedTable {
    pub name: &'static str,
    /// A number by which its rows are read in portions; `None` = it is small.
    portions_by: Option<&'static str>,
    /// Whether the rows get their numbers from the database.
    is_numbered: bool,
    /// A column that refers to any row of the same table.
    refers_to_itself: Option<&'static str>,
}

const fn numbered(name: &'static str, refers_to_itself: Option<&'static str>) -> CopiedTable {
    CopiedTable { name, portions_by: Some("id"), is_numbered: true, refers_to_itself }
}

const fn keyed(name: &'static str, portions_by: Option<&'static str>) -> CopiedTable {
    CopiedTable { name, portions_by, is_numbered: false, refers_to_itself: None }
}

/// All tables that both databases have.
pub(crate) const TABLES: [CopiedTable; 24] = [
    numbered("part", Some("replaced_by")),
    numbered("ticket", None),
    numbered("build", Some("repeats")),
    keyed("placement", Some("part_id")),
    keyed("bad_placement", Some("part_id")),
    numbered("event", None),
    numbered("outcome", None),
    numbered("pick_mark", None),
    keyed("finished_step", Some("part_id")),
    numbered("command", None),
    keyed("pause", None),
    keyed("loaded_material", None),
    keyed("node", None),
    keyed("station", None),
    keyed("receiver", None),
    keyed("replacement", Some("part_id")),
    keyed("customer_order", None),
    keyed("night_search", None),
    keyed("printer_down", None),
    keyed("request_key", None),
    keyed("ordered_line", None),
    keyed("person", None),
    keyed("session", None),
    keyed("farm_secret", None),
];
/// All views.
pub(crate) const VIEWS: [&str; 5] =
    ["build_copy", "v_build_history", "v_height_by_day", "v_order_line", "v_part_history"];

/// Numbers of a portion.
const PORTION: i64 = 2_000;
/// Most parameters of a statement; SQLite admits 32,766.
const MAX_PARAMETERS: usize = 30_000;

/// Why a ledger was not copied. The one that it should be copied to is as it was.
#[derive(Debug, Error)]
pub enum CopyError {
    /// The ledger to copy to has rows.
    #[error(
        "the ledger to copy to is not empty: it has rows in {table}. Name a new file, or a database that was just made"
    )]
    NotEmpty {
        /// The first table with rows.
        table: &'static str,
    },
    /// The copy differs.
    #[error("the copy was given up: {relation} would not hold the same rows. Please report this to nestd's makers")]
    Differs {
        /// The table or view.
        relation: &'static str,
    },
    /// An error of one of the two.
    #[error(transparent)]
    Ledger(#[from] LedgerError),
}

impl From<sqlx::Error> for CopyError {
    fn from(error: sqlx::Error) -> Self {
        Self::Ledger(error.into())
    }
}

/// What becomes of rows that are there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExistingRows {
    /// Nothing is copied.
    Refuse,
    /// The copied rows take their place.
    Replace,
}

/// What was copied.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CopyReport {
    /// Number of rows.
    pub rows: u64,
    /// Number of tables and views that were compared.
    pub compared: usize,
}

/// What a table or a view holds, whatever the order of its rows.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct RowsDigest {
    rows: u64,
    sum: u128,
}

impl Ledger {
    /// Copies everything in this ledger into another one, which a daemon may not serve.
    ///
    /// # Errors
    /// See [`CopyError`].
    pub async fn copy_into_ledger(&self, to: &Ledger, existing: ExistingRows) -> Result<CopyReport, CopyError> {
        for ledger in [self, to] {
            ledger.ensure_own_schema().await?;
        }
        let mut from = self.begin_snapshot().await?;
        let mut change = to.begin_change().await?;
        let db = change.db();
        from.allow_whole_ledger().await?;
        db.allow_whole_ledger().await?;
        clear_rows(db, existing).await?;
        let mut rows = 0;
        for table in &TABLES {
            rows += copy_table(&mut from, db, table).await?;
            if table.is_numbered {
                let last = sql::last_number(&mut from, table.name).await?;
                sql::set_last_number(db, table.name, last).await?;
            }
        }
        let relations: Vec<_> =
            TABLES.iter().map(|table| (table.name, true)).chain(VIEWS.map(|view| (view, false))).collect();
        for &(relation, is_table) in &relations {
            if digest_rows(&mut from, relation, is_table).await? != digest_rows(db, relation, is_table).await? {
                return Err(CopyError::Differs { relation });
            }
        }
        change.commit().await?;
        Ok(CopyReport { rows, compared: relations.len() })
    }
}

async fn clear_rows(db: &mut SqlTransaction, existing: ExistingRows) -> Result<(), CopyError> {
    for table in TABLES.iter().rev() {
        match (existing, table.refers_to_itself) {
            (ExistingRows::Refuse, _) => {
                let any = format!("SELECT count(*) FROM (SELECT 1 FROM {} LIMIT 1) AS any_row", table.name);
                if sql::query_scalar::<i64>(AssertSqlSafe(any)).fetch_one(&mut *db).await? > 0 {
                    return Err(CopyError::NotEmpty { table: table.name });
                }
                continue;
            }
            (ExistingRows::Replace, Some(column)) => {
                sql::query(AssertSqlSafe(format!("UPDATE {} SET {column} = NULL", table.name)))
                    .execute(&mut *db)
                    .await?;
            }
            (ExistingRows::Replace, None) => {}
        }
        sql::query(AssertSqlSafe(format!("DELETE FROM {}", table.name))).execute(&mut *db).await?;
    }
    Ok(())
}

/// Copies the rows of a table. Returns their number.
async fn copy_table(from: &mut SqlTransaction, to: &mut SqlTransaction, table: &CopiedTable) -> Result<u64, CopyError> {
    let holds: BTreeMap<String, ColumnHolds> = sql::column_types(to, table.name).await?.into_iter().collect();
    let (mut copied, mut references) = (0, Vec::new());
    let Some(key) = table.portions_by else {
        let all = sql::query_whole_rows(AssertSqlSafe(format!("SELECT * FROM {}", table.name)));
        let rows = all.fetch_all(&mut *from).await?;
        return insert_rows(to, table.name, rows, &holds).await;
    };
    let highest = format!("SELECT coalesce(max({key}), 0) FROM {}", table.name);
    let highest: i64 = sql::query_scalar(AssertSqlSafe(highest)).fetch_one(&mut *from).await?;
    for first in (0..=highest).step_by(PORTION as usize) {
        let some = format!("SELECT * FROM {} WHERE {key} >= $1 AND {key} < $2 ORDER BY {key}", table.name);
        let some = sql::query_whole_rows(AssertSqlSafe(some)).bind(first).bind(first + PORTION);
        let mut rows = some.fetch_all(&mut *from).await?;
        if let Some(column) = table.refers_to_itself {
            references.extend(rows.iter_mut().filter_map(|row| take_reference(row, column)));
        }
        copied += insert_rows(to, table.name, rows, &holds).await?;
    }
    for (id, refers_to) in references {
        let column = table.refers_to_itself.unwrap_or_default();
        let update = format!("UPDATE {} SET {column} = $1 WHERE id = $2", table.name);
        sql::query(AssertSqlSafe(update)).bind(refers_to).bind(id).execute(&mut *to).await?;
    }
    Ok(copied)
}

/// Takes the reference to another row of the same table out of a row. Returns the row's number and that of the other.
fn take_reference(row: &mut DynamicRow, column: &str) -> Option<(i64, i64)> {
    let number = |value: &SqlValue| if let SqlValue::Integer(number) = value { *number } else { None };
    let id = row.iter().find(|(name, _)| name == "id").and_then(|(_, id)| number(id))?;
    let (_, value) = row.iter_mut().find(|(name, _)| name == column)?;
    let refers_to = number(value)?;
    *value = SqlValue::Integer(None);
    Some((id, refers_to))
}

async fn insert_rows(
    to: &mut SqlTransaction,
    table: &str,
    mut rows: Vec<DynamicRow>,
    holds: &BTreeMap<String, ColumnHolds>,
) -> Result<u64, CopyError> {
    let Some(first) = rows.first() else { return Ok(0) };
    let names: Vec<String> = first.iter().map(|(name, _)| name.clone()).collect();
    let count = rows.len() as u64;
    while !rows.is_empty() {
        let some: Vec<DynamicRow> = rows.drain(..rows.len().min(MAX_PARAMETERS / names.len())).collect();
        let row_text = |row: usize| {
            let places: Vec<String> =
                (1..=names.len()).map(|place| format!("${}", row * names.len() + place)).collect();
            format!("({})", places.join(", "))
        };
        let values: Vec<String> = (0..some.len()).map(row_text).collect();
        let text = format!("INSERT INTO {table} ({}) VALUES {}", names.join(", "), values.join(", "));
        let values = some.into_iter().flatten().map(|(name, value)| match holds.get(&name) {
            Some(&holds) => value.held_as(holds),
            None => value,
        });
        let insert = values.fold(sql::query(AssertSqlSafe(text)), |insert, value| insert.bind(value));
        insert.execute(&mut *to).await?;
    }
    Ok(count)
}

async fn digest_rows(db: &mut SqlTransaction, relation: &str, is_table: bool) -> Result<RowsDigest, CopyError> {
    let mut digest = RowsDigest::default();
    let all = sql::query_whole_rows(AssertSqlSafe(format!("SELECT * FROM {relation}")));
    all.for_each(db, |row| digest.add(row, is_table)).await?;
    Ok(digest)
}

impl RowsDigest {
    fn add(&mut self, mut row: DynamicRow, is_table: bool) {
        row.sort_by(|a, b| a.0.cmp(&b.0));
        let mut hash = blake3::Hasher::new();
        for (name, value) in row {
            let text = match value {
                SqlValue::Integer(Some(number)) => number.to_string(),
                SqlValue::Flag(Some(flag)) => i64::from(flag).to_string(),
                // SQLite stores 0 for -0, which an earlier release has written on a server.
                // What a view computes is rounded, and its tables are compared to the last bit.
                SqlValue::Real(Some(number)) if is_table => format!("{:016x}", (number + 0.0).to_bits()),
                // The builds of a part are a set: each database lists them in an order of its own.
                SqlValue::Text(Some(list)) if name == "builds" => {
                    list.split(',').collect::<BTreeSet<_>>().into_iter().collect::<Vec<_>>().join(",")
                }
                SqlValue::Text(Some(text)) => text,
                _ => continue,
            };
            hash.update(name.as_bytes()).update(&(text.len() as u64).to_le_bytes()).update(text.as_bytes());
        }
        let mut low = [0; 16];
        hash.finalize_xof().fill(&mut low);
        self.rows += 1;
        self.sum = self.sum.wrapping_add(u128::from_le_bytes(low));
    }
}
