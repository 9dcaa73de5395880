//! What the two databases are asked or told about themselves in different words.

use sqlx::Result;

use super::{SqlTransaction, query, query_scalar};

/// The columns of a table, in their order.
pub async fn table_columns(db: &mut SqlTransaction, table: &str) -> Result<Vec<String>> {
    let text = match db {
        SqlTransaction::Sqlite(_) => "SELECT name FROM pragma_table_info($1) ORDER BY cid",
        #[cfg(feature = "postgres")]
        SqlTransaction::Postgres(_) => {
            "SELECT CAST(column_name AS TEXT) FROM information_schema.columns \
             WHERE table_schema = current_schema() AND table_name = $1 ORDER BY ordinal_position"
        }
    };
    query_scalar(text).bind(table).fetch_all(db).await
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
        #[cfg(feature = "postgres")]
        SqlTransaction::Postgres(_) => {
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
        #[cfg(feature = "postgres")]
        (db @ SqlTransaction::Postgres(_), table) => {
            let highest = format!(
                "SELECT setval(s.name, greatest((SELECT max(id) FROM {table}), nextval(s.name) - 1, 1)) \
                 FROM (SELECT pg_get_serial_sequence($1, 'id') AS name) AS s"
            );
            query(sqlx::AssertSqlSafe(highest)).bind(table).execute(db).await?;
        }
    }
    Ok(())
}
