//! A statement with the values of its parameters.

use std::{marker::PhantomData, pin::Pin};

use sqlx::{
    AssertSqlSafe, Database, Encode, Error, Executor, IntoArguments, SqlSafeStr, SqlStr, Type,
    database::HasStatementCache, query::Query,
};
use tokio_stream::StreamExt;

use crate::ServerError;

use super::{
    BindValue, ColumnKey, ColumnValue, DynamicRow, FromSqlRow, NamedColumns, SqlExecutor, SqlRow, SqlValue,
    answered_within,
};

/// The answer of a database. Its future has one type, so that what waits for it in other crates is compiled without the driver.
type BoxedAnswer<'c, T> = Pin<Box<dyn Future<Output = Result<T, Error>> + Send + 'c>>;

/// A statement that returns no rows.
pub struct SqlQuery {
    text: SqlStr,
    values: Vec<SqlValue>,
    /// Whether the database keeps what it has made of it.
    is_prepared: bool,
}

/// A statement whose rows are read as `T`.
pub struct TypedQuery<T> {
    query: SqlQuery,
    read: fn(&SqlRow) -> Result<T, Error>,
    rows: PhantomData<T>,
}

/// Begins a statement that returns no rows.
pub fn query(text: impl SqlSafeStr) -> SqlQuery {
    SqlQuery { text: text.into_sql_str(), values: Vec::new(), is_prepared: true }
}

/// Begins a statement whose rows are read as a whole.
pub fn query_as<T: FromSqlRow>(text: impl SqlSafeStr) -> TypedQuery<T> {
    TypedQuery { query: query(text), read: T::from_sql_row, rows: PhantomData }
}

/// Begins a statement that reads the columns of `T`. `from` = what follows after the columns: `FROM ..`.
pub fn select_as<T: NamedColumns>(from: &str) -> TypedQuery<T> {
    let mut names = Vec::new();
    T::add_columns(&mut names);
    query_as(AssertSqlSafe(format!("SELECT {} {from}", names.join(", "))))
}

/// Begins a statement whose rows are read with all columns that they have.
pub fn query_whole_rows(text: impl SqlSafeStr) -> TypedQuery<DynamicRow> {
    let query = SqlQuery { is_prepared: false, ..query(text) };
    TypedQuery { query, read: SqlRow::values, rows: PhantomData }
}

/// Begins a statement of whose rows the first column is read.
pub fn query_scalar<T: ColumnValue>(text: impl SqlSafeStr) -> TypedQuery<T> {
    TypedQuery { query: query(text), read: |row| T::read(row, ColumnKey::Place(0)), rows: PhantomData }
}

impl SqlQuery {
    /// Binds the next parameter.
    pub fn bind(mut self, value: impl BindValue) -> Self {
        self.values.push(value.to_sql());
        self
    }

    /// Runs it. Returns the number of rows that it changed.
    pub fn execute<'c>(self, on: impl Into<SqlExecutor<'c>>) -> BoxedAnswer<'c, u64> {
        self.execute_on(on.into())
    }

    fn execute_on(self, on: SqlExecutor<'_>) -> BoxedAnswer<'_, u64> {
        Box::pin(async {
            match on {
                SqlExecutor::SqlitePool(pool) => Ok(with_values(self).execute(pool).await?.rows_affected()),
                SqlExecutor::Sqlite(db) => Ok(with_values(self).execute(db).await?.rows_affected()),
                SqlExecutor::PostgresPool(pool, limit) => {
                    let done = answered_within(limit, with_values(self).execute(pool)).await;
                    Ok(done.map_err(ServerError::mark_unreachable)?.rows_affected())
                }
                SqlExecutor::Postgres(db, limit) => {
                    let done = answered_within(limit, with_values(self).execute(db)).await;
                    Ok(done.map_err(ServerError::mark_unreachable)?.rows_affected())
                }
            }
        })
    }

    /// Runs it and hands each row to `take`, until that returns `false`.
    fn for_each_row<'c>(self, on: SqlExecutor<'c>, take: RowTaker<'c>) -> BoxedAnswer<'c, ()> {
        Box::pin(async {
            match on {
                SqlExecutor::SqlitePool(pool) => take_rows(pool, with_values(self), SqlRow::Sqlite, take).await,
                SqlExecutor::Sqlite(db) => take_rows(db, with_values(self), SqlRow::Sqlite, take).await,
                SqlExecutor::PostgresPool(pool, limit) => {
                    let rows = take_rows(pool, with_values(self), SqlRow::Postgres, take);
                    let done = answered_within(limit, rows).await;
                    done.map_err(ServerError::mark_unreachable)
                }
                SqlExecutor::Postgres(db, limit) => {
                    let rows = take_rows(db, with_values(self), SqlRow::Postgres, take);
                    let done = answered_within(limit, rows).await;
                    done.map_err(ServerError::mark_unreachable)
                }
            }
        })
    }
}

impl<T: Send> TypedQuery<T> {
    /// Binds the next parameter.
    pub fn bind(mut self, value: impl BindValue) -> Self {
        self.query.values.push(value.to_sql());
        self
    }

    /// Reads all rows.
    pub async fn fetch_all(self, on: impl Into<SqlExecutor<'_>>) -> Result<Vec<T>, Error> {
        let mut all = Vec::new();
        let read = self.read;
        let mut take = |row: SqlRow| {
            all.push(read(&row)?);
            Ok(true)
        };
        self.query.for_each_row(on.into(), &mut take).await?;
        Ok(all)
    }

    /// Hands each row to `take`, one after the other.
    pub async fn for_each(self, on: impl Into<SqlExecutor<'_>>, mut take: impl FnMut(T) + Send) -> Result<(), Error> {
        let read = self.read;
        let mut take = |row: SqlRow| {
            take(read(&row)?);
            Ok(true)
        };
        self.query.for_each_row(on.into(), &mut take).await
    }

    /// Hands each row to `take`, one after the other, until that returns `false`.
    pub async fn for_each_while(
        self,
        on: impl Into<SqlExecutor<'_>>,
        mut take: impl FnMut(T) -> bool + Send,
    ) -> Result<(), Error> {
        let read = self.read;
        self.query.for_each_row(on.into(), &mut |row: SqlRow| Ok(take(read(&row)?))).await
    }

    /// Reads the first row, if there is one.
    pub async fn fetch_optional(self, on: impl Into<SqlExecutor<'_>>) -> Result<Option<T>, Error> {
        let mut first = None;
        let read = self.read;
        let mut take = |row: SqlRow| {
            first = Some(read(&row)?);
            Ok(false)
        };
        self.query.for_each_row(on.into(), &mut take).await?;
        Ok(first)
    }

    /// Reads the first row. `RowNotFound` if there is none.
    pub async fn fetch_one(self, on: impl Into<SqlExecutor<'_>>) -> Result<T, Error> {
        self.fetch_optional(on).await?.ok_or(Error::RowNotFound)
    }
}

/// Takes a row, and says whether it wants another.
type RowTaker<'a> = &'a mut (dyn FnMut(SqlRow) -> Result<bool, Error> + Send);

async fn take_rows<'c, DB: Database>(
    on: impl Executor<'c, Database = DB>,
    query: Query<'static, DB, DB::Arguments>,
    wrap: fn(DB::Row) -> SqlRow,
    take: RowTaker<'_>,
) -> Result<(), Error>
where
    DB::Arguments: IntoArguments<DB>,
{
    let mut rows = query.fetch(on);
    while let Some(row) = rows.next().await {
        if !take(wrap(row?))? {
            break;
        }
    }
    Ok(())
}

fn with_values<DB>(query: SqlQuery) -> Query<'static, DB, DB::Arguments>
where
    DB: Database + HasStatementCache,
    Option<i64>: Encode<'static, DB> + Type<DB>,
    Option<f64>: Encode<'static, DB> + Type<DB>,
    Option<bool>: Encode<'static, DB> + Type<DB>,
    Option<String>: Encode<'static, DB> + Type<DB>,
{
    let statement = sqlx::query(query.text).persistent(query.is_prepared);
    query.values.into_iter().fold(statement, |query, value| match value {
        SqlValue::Integer(value) => query.bind(value),
        // SQLite stores 0 for -0: so that both databases hold the same, no -0 is written.
        SqlValue::Real(value) => query.bind(value.map(|value| value + 0.0)),
        SqlValue::Flag(value) => query.bind(value),
        SqlValue::Text(value) => query.bind(value),
    })
}
