//! The schemas of the two databases are written by hand, twice: tables, views, columns, indexes and the words that columns
//! admit must be the same.

use std::collections::{BTreeMap, BTreeSet};

use super::*;

/// Tables of one of the two: the count of changes of a file; leases, and who can use the ledger, of a server.
const OF_ONE_ALONE: [&str; 5] = ["change_count", "lease", "lease_change", "repair_due", "schema_range"];

/// A relation: its columns by name, and the words that its checks admit.
#[derive(Debug, Default, PartialEq)]
struct RelationShape {
    is_view: bool,
    columns: BTreeMap<String, ColumnShape>,
    words: BTreeSet<String>,
}

/// A column: what it holds, and, in a table, whether it may be NULL and whether it has a default.
#[derive(Debug, PartialEq)]
struct ColumnShape {
    holds: &'static str,
    nullable_and_default: Option<(bool, bool)>,
}

async fn rows<T: FromSqlRow + Send>(ledger: &Ledger, text: &str) -> Vec<T> {
    let query = sql::query_as::<T>(sqlx::AssertSqlSafe(text.to_owned()));
    query.fetch_all(ledger.reader().unwrap()).await.unwrap()
}

async fn sqlite_shapes(ledger: &Ledger) -> BTreeMap<String, RelationShape> {
    let relations: Vec<(String, String, String)> =
        rows(ledger, "SELECT name, type, sql FROM sqlite_schema WHERE type IN ('table', 'view')").await;
    let mut shapes = BTreeMap::new();
    for (name, kind, text) in relations.into_iter().filter(|(name, ..)| is_of_ledger(name)) {
        let columns: Vec<(String, String, bool, bool, i64)> = rows(
            ledger,
            &format!("SELECT name, type, \"notnull\", dflt_value IS NOT NULL, pk FROM pragma_table_info('{name}')"),
        )
        .await;
        let is_view = kind == "view";
        let column = |(name, holds, is_required, has_default, key): (String, String, bool, bool, i64)| {
            let nullable_and_default = (!is_view).then_some((!is_required && key == 0, has_default));
            (name, ColumnShape { holds: kind_of(&holds), nullable_and_default })
        };
        let columns = columns.into_iter().map(column).collect();
        shapes.insert(name, RelationShape { is_view, columns, words: admitted_words(&text) });
    }
    shapes
}

async fn postgres_shapes(ledger: &Ledger) -> BTreeMap<String, RelationShape> {
    let mut shapes: BTreeMap<String, RelationShape> = BTreeMap::new();
    let relations: Vec<(String, bool)> = rows(
        ledger,
        "SELECT CAST(table_name AS TEXT), table_type = 'VIEW' FROM information_schema.tables \
         WHERE table_schema = current_schema()",
    )
    .await;
    for (name, is_view) in relations.into_iter().filter(|(name, _)| is_of_ledger(name)) {
        shapes.insert(name, RelationShape { is_view, ..RelationShape::default() });
    }
    let columns: Vec<(String, String, String, bool, bool)> = rows(
        ledger,
        "SELECT CAST(table_name AS TEXT), CAST(column_name AS TEXT), CAST(data_type AS TEXT), is_nullable = 'YES', \
         column_default IS NOT NULL FROM information_schema.columns WHERE table_schema = current_schema()",
    )
    .await;
    for (relation, name, holds, is_nullable, has_default) in columns {
        let Some(shape) = shapes.get_mut(&relation) else { continue };
        let nullable_and_default = (!shape.is_view).then_some((is_nullable, has_default));
        shape.columns.insert(name, ColumnShape { holds: kind_of(&holds), nullable_and_default });
    }
    let checks: Vec<(String, String)> = rows(
        ledger,
        "SELECT CAST(conrelid::regclass AS TEXT), pg_get_constraintdef(oid) FROM pg_constraint WHERE contype = 'c'",
    )
    .await;
    for (relation, text) in checks {
        if let Some(shape) = shapes.get_mut(&relation) {
            shape.words.extend(admitted_words(&text));
        }
    }
    shapes
}

fn is_of_ledger(relation: &str) -> bool {
    !relation.starts_with("sqlite_") && relation != "_sqlx_migrations" && !OF_ONE_ALONE.contains(&relation)
}

/// SQLite has no type for true and false; a computed column of a view has none at all there.
fn kind_of(declared: &str) -> &'static str {
    match declared {
        "INTEGER" | "bigint" | "boolean" => "a whole number",
        "REAL" | "double precision" => "a number",
        "TEXT" | "text" => "text",
        "" => "computed",
        other => panic!("{other}"),
    }
}

/// The words in quotes inside the checks of a text.
fn admitted_words(text: &str) -> BTreeSet<String> {
    let inside = |check: &str| {
        let mut depth = 1;
        let end = check.find(|c| {
            depth += i32::from(c == '(') - i32::from(c == ')');
            depth == 0
        });
        check[..end.expect("a check is closed")].split('\'').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>()
    };
    text.split("CHECK (").skip(1).flat_map(inside).collect()
}

#[tokio::test]
async fn tables_views_and_their_columns_are_the_same_on_both() {
    let (file, server) = both().await;
    let (mut sqlite, mut postgres) = (sqlite_shapes(&file).await, postgres_shapes(&server).await);
    let names = |shapes: &BTreeMap<String, RelationShape>| shapes.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&sqlite), names(&postgres));
    assert!(sqlite.len() > 15 && sqlite["part"].columns.len() > 30, "{:?}", names(&sqlite));
    assert!(sqlite["command"].words.contains("confirm") && sqlite["build"].words.contains("interrupted"));
    for (name, shape) in &mut sqlite {
        let other = postgres.get_mut(name).unwrap();
        for (column, one) in &mut shape.columns {
            if one.holds == "computed" && other.columns.contains_key(column) {
                one.holds = other.columns[column].holds;
            }
        }
        assert_eq!(shape, other, "{name}");
    }
}

#[tokio::test]
async fn indexes_are_the_same_on_both() {
    let (file, server) = both().await;
    let sqlite: Vec<(String, String, bool)> = rows(
        &file,
        "SELECT tbl_name, name, sql LIKE 'CREATE UNIQUE%' FROM sqlite_schema WHERE type = 'index' AND sql IS NOT NULL",
    )
    .await;
    let postgres: Vec<(String, String, bool)> = rows(
        &server,
        "SELECT CAST(i.indrelid::regclass AS TEXT), CAST(i.indexrelid::regclass AS TEXT), i.indisunique FROM pg_index i \
         JOIN pg_class c ON c.oid = i.indexrelid WHERE c.relnamespace = CAST(current_schema() AS regnamespace) \
         AND NOT EXISTS (SELECT 1 FROM pg_constraint k WHERE k.conindid = i.indexrelid AND k.contype IN ('p', 'u'))",
    )
    .await;
    let sorted = |rows: Vec<(String, String, bool)>| rows.into_iter().collect::<BTreeSet<_>>();
    let (sqlite, postgres) = (sorted(sqlite), sorted(postgres));
    assert!(sqlite.len() > 20, "{sqlite:?}");
    assert_eq!(sqlite, postgres);
}
