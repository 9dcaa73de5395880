//! What the two databases are asked or told about themselves in different words.

use sqlx::Result;

use super::{ColumnHolds, SqlTransaction, query, query_as, query_scalar};

/// The columns of a table, in their order.
pub async fn table_columns(db: &mut SqlTransaction, table: &str) -> Result<Vec<String>> {
    Ok(column_types(db, table).await?.into_iter().map(|(name, _)| name).collect())
}

/// The columns of a table, in their order, with what each holds.
pub async fn column_types(db: &mut SqlTransaction, table: &str) -> Result<Vec<(String, ColumnHolds)>> {
    let text = match db {
        SqlTransaction::Sqlite(_) => "SELECT name, type FROM pragma_table_info($1) ORDER BY cid",
        SqlTransaction::Postgres(..) => {
            "SELECT CAST(column_name AS TEXT), CAST(data_type AS TEXT) FROM information_schema.columns \
             WHERE table_schema = current_schema() AND table_name = $1 ORDER BY ordinal_position"
        }
    };
    let columns: Vec<(String, String)> = query_as(text).bind(table).fetch_all(db).await?;
    let holds = |kind: &str| match kind {
        "INTEGER" | "bigint" => ColumnHolds::Integer,
        "REAL" | "double precision" => ColumnHolds::Real,
        "boolean" => ColumnHolds::Flag,
        _ => ColumnHolds::Text,
    };
    Ok(columns.into_iter().map(|(name, kind)| (name, holds(&kind))).collect())
}

/// The number that the last new row of a table got, whether the row is still there or not; 0 = there was none.
pub async fn last_number(db: &mut SqlTransaction, table: &str) -> Result<i64> {
    let last = match db {
        SqlTransaction::Sqlite(_) => {
            query_scalar("SELECT coalesce(max(seq), 0) FROM sqlite_sequence WHERE name = $1").bind(table)
        }
        SqlTransaction::Postgres(..) => {
            let text =
                format!("SELECT CASE WHEN is_called THEN last_value ELSE last_value - 1 END FROM {table}_id_seq");
            query_scalar(sqlx::AssertSqlSafe(text))
        }
    };
    last.fetch_one(db).await
}

/// Sets the number that the last new row of a table got.
pub async fn set_last_number(db: &mut SqlTransaction, table: &str, last: i64) -> Result<()> {
    match db {
        SqlTransaction::Sqlite(_) => {
            query("DELETE FROM sqlite_sequence WHERE name = $1").bind(table).execute(&mut *db).await?;
            let insert = query("INSERT INTO sqlite_sequence (name, seq) VALUES ($1, $2)").bind(table).bind(last);
            insert.execute(db).await?;
        }
        SqlTransaction::Postgres(..) => {
            let set = query("SELECT setval(pg_get_serial_sequence($1, 'id'), greatest($2, 1), $2 > 0)");
            set.bind(table).bind(last).execute(db).await?;
        }
    }
    Ok(())
}

/// Raises the number that the next row of a table gets by `gap`.
pub async fn skip_numbers(db: &mut SqlTransaction, table: &str, gap: u32) -> Result<()> {
    match db {
        SqlTransaction::Sqlite(_) => {
            let known = query("UPDATE sqlite_sequence SET seq = seq + $1 WHERE name = $2").bind(gap).bind(table);
            if known.execute(&mut *db).await? == 0 {
                let insert = query("INSERT INTO sqlite_sequence (name, seq) VALUES ($1, $2)").bind(table).bind(gap);
                insert.execute(db).await?;
            }
        }
        SqlTransaction::Postgres(..) => {
            let skip =
                "SELECT setval(pg_get_serial_sequence($1, 'id'), nextval(pg_get_serial_sequence($1, 'id')) + $2)";
            query(skip).bind(table).bind(gap).execute(db).await?;
        }
    }
    Ok(())
}

/// Keeps the numbers of new rows above those that rows of a table were given with their insertion. SQLite does so itself.
pub async fn number_from_highest(db: &mut SqlTransaction, table: &str) -> Result<()> {
    match (db, table) {
        (SqlTransaction::Sqlite(_), _) => {}
        (db @ SqlTransaction::Postgres(..), table) => {
            let highest = format!(
                "SELECT setval(s.name, greatest((SELECT max(id) FROM {table}), nextval(s.name) - 1, 1)) \
                 FROM (SELECT pg_get_serial_sequence($1, 'id') AS name) AS s"
            );
            query(sqlx::AssertSqlSafe(highest)).bind(table).execute(db).await?;
        }
    }
    Ok(())
}
