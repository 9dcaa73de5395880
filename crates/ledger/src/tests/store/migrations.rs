//! Tests that a ledger of any earlier schema is migrated to the current one and keeps every row.

use std::{borrow::Cow, path::Path};

use sqlx::{
    Row, SqlitePool,
    migrate::{Migration, Migrator},
    sqlite::SqliteConnectOptions,
};

use crate::{store::schema::MIGRATIONS, tests::*};

/// A row for each table of the first schema; later schemas have these tables too.
const ROWS: &str = "
    INSERT INTO part (id, claim, profile, name, content_hash, bytes, state, reason, copies, claimed_at, state_at) VALUES
        (1, 'c1', 'paper-200', 'a.stl', 'aa', 684, 'built', '', 1, '2026-11-01T00:00:00.000Z', '2026-11-02T00:00:00.000Z'),
        (7, 'c7', 'paper-200', 'b.stl', 'bb', 685, 'rejected', 'too large', 3, '2026-11-01T00:00:00.000Z', '2026-11-01T00:00:00.000Z');
    INSERT INTO ticket VALUES (1, 1, 'sidecar', 'a.stl.toml', 'copies = 1', '2026-11-01T00:00:00.000Z');
    INSERT INTO build (id, profile, state, opened_at, nesting_at, verified_at, published_at, state_at, file_name, height_mm, copies)
        VALUES (4, 'paper-200', 'complete', '2026-11-01T00:00:00.000Z', '2026-11-01T00:00:00.000Z', '2026-11-01T00:00:00.000Z',
                '2026-11-02T00:00:00.000Z', '2026-11-03T00:00:00.000Z', 'x.build.3mf', 87.5, 1);
    INSERT INTO placement (part_id, copy, build_id, qx, qy, qz, qw, tx_mm, ty_mm, tz_mm) VALUES (1, 0, 4, 0, 0, 0, 1, 1, 2, 3);
    INSERT INTO event (id, at, kind, profile, part_id, build_id, detail) VALUES (1, '2026-11-01T00:00:00.000Z', 'built', 'paper-200', 1, NULL, ''),
        (2, '2026-11-01T00:00:00.000Z', 'rejected', 'paper-200', 7, NULL, 'too large'),
        (3, '2026-11-03T00:00:00.000Z', 'complete', 'paper-200', NULL, 4, '');
    INSERT INTO outcome (id, build_id, outcome, note, told_by, told_at) VALUES (1, 4, 'complete', 'fine', 'me@here', '2026-11-03T00:00:00.000Z');
    INSERT INTO command (id, kind, profile, part_id, asked_by, asked_at, state, answer, answered_at) VALUES (1, 'retry', '', 7, 'me@here', '2026-11-03T00:00:00.000Z', 'refused', 'no', '2026-11-03T00:00:00.000Z');
    INSERT INTO pause (profile, paused_by, paused_at) VALUES ('paper-200', 'me@here', '2026-11-03T00:00:00.000Z');";

const TABLES: [&str; 8] = ["part", "ticket", "build", "placement", "event", "outcome", "command", "pause"];

/// Since this schema, a machine and a refused part are called so; before, `profile` and `rejected`.
const FIRST_WITH_MACHINES: i64 = 40;

/// A text with the words of the current schema in place of earlier ones.
fn in_words_of_now(text: &str) -> String {
    text.replace("profile,", "machine,").replace("(profile", "(machine").replace("'rejected'", "'refused'")
}

/// Since this schema, a daemon is a row of `node`.
const FIRST_WITH_NODES: i64 = 22;
const DAEMON: &str = "INSERT INTO daemon VALUES (1, 42, 'here', '0.1.0', '2026-11-03T00:00:00.000Z', '2026-11-03T00:00:00.000Z', 'idle')";

async fn raw(path: &Path) -> SqlitePool {
    SqlitePool::connect_with(SqliteConnectOptions::new().filename(path).create_if_missing(true)).await.unwrap()
}

async fn text(pool: &SqlitePool, query: String) -> Vec<String> {
    sqlx::query_scalar(sqlx::AssertSqlSafe(query)).fetch_all(pool).await.unwrap()
}

/// The whole schema as stored by SQLite.
async fn schema_of(path: &Path) -> Vec<String> {
    let query = "SELECT type || ' ' || name || ': ' || coalesce(sql, '') FROM sqlite_schema ORDER BY type, name";
    text(&raw(path).await, query.to_owned()).await
}

/// The columns that a table has now, and its rows in these columns.
async fn rows_of(pool: &SqlitePool, table: &str, columns: &[String]) -> Vec<String> {
    let values = columns.iter().map(|column| format!("quote({column})")).collect::<Vec<_>>().join(" || ',' || ");
    text(pool, format!("SELECT {values} FROM {table} ORDER BY 1")).await
}

async fn columns_of(pool: &SqlitePool, table: &str) -> Vec<String> {
    text(pool, format!("SELECT name FROM pragma_table_info('{table}') ORDER BY cid")).await
}

#[tokio::test]
async fn a_ledger_of_every_earlier_schema_becomes_like_a_new_one_and_keeps_its_rows() {
    let folder = tempfile::tempdir().unwrap();
    let new = folder.path().join("new.db");
    Ledger::open(&new).await.unwrap().close().await;
    for version in 1..=MIGRATIONS.iter().count() {
        let path = folder.path().join(format!("{version}.db"));
        let pool = raw(&path).await;
        let earlier: Vec<_> = MIGRATIONS.iter().take(version).cloned().collect();
        let has = |first: i64| earlier.iter().any(|migration| migration.version >= first);
        let (has_nodes, has_machines) = (has(FIRST_WITH_NODES), has(FIRST_WITH_MACHINES));
        Migrator { migrations: Cow::Owned(earlier), ..Migrator::DEFAULT }.run(&pool).await.unwrap();
        let rows = if has_machines { in_words_of_now(ROWS) } else { ROWS.to_owned() };
        sqlx::raw_sql(sqlx::AssertSqlSafe(rows)).execute(&pool).await.unwrap();
        if !has_nodes {
            sqlx::raw_sql(DAEMON).execute(&pool).await.unwrap();
        }
        let mut before = Vec::new();
        for table in TABLES {
            let columns = columns_of(&pool, table).await;
            let rows = rows_of(&pool, table, &columns).await;
            assert!(!rows.is_empty(), "{table}");
            let columns = columns.into_iter().map(|name| if name == "profile" { "machine".to_owned() } else { name });
            let rows: Vec<_> = rows.iter().map(|row| in_words_of_now(row)).collect();
            before.push((table, columns.collect::<Vec<_>>(), rows));
        }
        pool.close().await;
        let ledger = Ledger::open_checked(&path).await.unwrap();
        assert_eq!(ledger.find_inconsistencies().await.unwrap(), Vec::<String>::new(), "from schema {version}");
        let history = ledger.read_history(&HistoryQuery::default()).await.unwrap();
        assert_eq!((history.len(), history[0].measures.height_mm), (1, Some(87.5)));
        ledger.close().await;
        let pool = raw(&path).await;
        let nodes = text(&pool, "SELECT name || ' ' || pid || ' ' || status FROM node".to_owned()).await;
        assert_eq!(nodes, if has_nodes { vec![] } else { vec!["here 42 idle"] }, "from schema {version}");
        for (table, columns, rows) in before {
            assert_eq!(rows_of(&pool, table, &columns).await, rows, "{table} from schema {version}");
        }
        pool.close().await;
        assert_eq!(schema_of(&path).await, schema_of(&new).await, "from schema {version}");
    }
}

#[tokio::test]
async fn a_pause_of_the_daemon_in_an_earlier_ledger_stays_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("nestd.db");
    let pool = raw(&path).await;
    let earlier: Vec<_> = MIGRATIONS.iter().filter(|migration| migration.version < 17).cloned().collect();
    Migrator { migrations: Cow::Owned(earlier), ..Migrator::DEFAULT }.run(&pool).await.unwrap();
    let pauses = "INSERT INTO pause VALUES ('a', 'nestd', '2026-11-03T00:00:00.000Z'), ('b', 'me@here', '2026-11-03T00:00:00.000Z')";
    sqlx::query(pauses).execute(&pool).await.unwrap();
    pool.close().await;
    let ledger = Ledger::open(&path).await.unwrap();
    let causes: Vec<_> =
        ledger.machine_statuses().await.unwrap().into_iter().map(|row| row.paused.unwrap().cause).collect();
    assert_eq!(causes, [PauseCause::BuildFailed, PauseCause::Person]);
}

#[tokio::test]
async fn orders_of_an_earlier_ledger_are_found_in_any_letter_case_also_of_umlauts() {
    let folder = tempfile::tempdir().unwrap();
    for (before, orders_are_kept) in [(18, false), (20, true)] {
        let path = folder.path().join(format!("{before}.db"));
        let pool = raw(&path).await;
        let earlier: Vec<_> = MIGRATIONS.iter().filter(|migration| migration.version < before).cloned().collect();
        Migrator { migrations: Cow::Owned(earlier), ..Migrator::DEFAULT }.run(&pool).await.unwrap();
        for (number, order) in ["M\u{dc}LLER", "M\u{fc}ller", "Brandt"].into_iter().enumerate() {
            let part = "INSERT INTO part (claim, profile, name, order_name, content_hash, bytes, state, copies, claimed_at, state_at) \
                VALUES ($1, 'paper-200', 'a.stl', $2, 'aa', 684, 'waiting', 1, '2026-11-01T00:00:00.000Z', '2026-11-01T00:00:00.000Z')";
            sqlx::query(part).bind(format!("c{number}")).bind(order).execute(&pool).await.unwrap();
            if orders_are_kept {
                // As the upgrade to the first schema with orders wrote them.
                let row = "INSERT INTO customer_order SELECT $1, lower($1), 'open', '2026-11-01T00:00:00.000Z', '2026-11-01T00:00:00.000Z'";
                sqlx::query(row).bind(order).execute(&pool).await.unwrap();
            }
        }
        pool.close().await;
        let ledger = Ledger::open_checked(&path).await.unwrap();
        for (asked, count) in [("m\u{fc}ller", 2), ("M\u{dc}LL", 2), ("BRANDT", 1), ("muller", 0)] {
            let query = OrderQuery { name: Some(asked.to_owned()), limit: 9, ..OrderQuery::default() };
            assert_eq!(ledger.list_orders(&query).await.unwrap().len(), count, "{asked} from before schema {before}");
        }
        ledger.close().await;
    }
}

#[tokio::test]
async fn customers_that_stood_in_notes_become_a_field_of_parts_and_orders() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("nestd.db");
    let pool = raw(&path).await;
    let earlier: Vec<_> = MIGRATIONS.iter().filter(|migration| migration.version < 41).cloned().collect();
    Migrator { migrations: Cow::Owned(earlier), ..Migrator::DEFAULT }.run(&pool).await.unwrap();
    let notes = [
        ("K", "urgent; customer: M\u{fc}ller & S\u{f6}hne; material: PA12"),
        ("K", "customer: Brandt"),
        ("K", "ask the customer: he knows"),
        ("", "customer: Brandt; material: PA12"),
    ];
    for (number, (order, note)) in notes.into_iter().enumerate() {
        let part = "INSERT INTO part (claim, machine, name, order_name, note, content_hash, bytes, copies, claimed_at, state_at) \
            VALUES ($1, 'm', 'a.stl', $2, $3, 'aa', 684, 1, '2026-11-01T00:00:00.000Z', '2026-11-01T00:00:00.000Z')";
        sqlx::query(part).bind(format!("c{number}")).bind(order).bind(note).execute(&pool).await.unwrap();
    }
    let order = "INSERT INTO customer_order (name, folded, state, opened_at, state_at) \
        VALUES ('K', 'k', 'open', '2026-11-01T00:00:00.000Z', '2026-11-01T00:00:00.000Z')";
    sqlx::query(order).execute(&pool).await.unwrap();
    pool.close().await;
    let ledger = Ledger::open(&path).await.unwrap();
    let mut customers = Vec::new();
    for id in 1..=4 {
        customers.push(ledger.find_part(PartId(id)).await.unwrap().unwrap().terms.customer);
    }
    assert_eq!(customers, ["M\u{fc}ller & S\u{f6}hne", "Brandt", "", "Brandt"]);
    assert_eq!(ledger.find_order("K").await.unwrap().unwrap().customer, "Brandt, M\u{fc}ller & S\u{f6}hne");
}

#[tokio::test]
async fn materials_that_stood_in_notes_become_a_field_and_their_parts_wait_until_they_are_loaded() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("nestd.db");
    let pool = raw(&path).await;
    let earlier: Vec<_> = MIGRATIONS.iter().filter(|migration| migration.version < 42).cloned().collect();
    Migrator { migrations: Cow::Owned(earlier), ..Migrator::DEFAULT }.run(&pool).await.unwrap();
    for (number, note) in ["urgent; material: PA 12", "material: PA11", "the material: any"].into_iter().enumerate() {
        let part = "INSERT INTO part (claim, machine, name, note, state, content_hash, bytes, copies, claimed_at, state_at) \
            VALUES ($1, 'm', 'a.stl', $2, 'waiting', 'aa', 684, 1, '2026-11-01T00:00:00.000Z', '2026-11-01T00:00:00.000Z')";
        sqlx::query(part).bind(format!("c{number}")).bind(note).execute(&pool).await.unwrap();
    }
    pool.close().await;
    let ledger = Ledger::open(&path).await.unwrap();
    let mut found = Vec::new();
    for id in 1..=3 {
        let part = ledger.find_part(PartId(id)).await.unwrap().unwrap();
        found.push((part.terms.material, part.owed.awaits_material));
    }
    assert_eq!(found, [("PA 12".to_owned(), true), ("PA11".to_owned(), true), (String::new(), false)]);
}

#[tokio::test]
async fn the_list_of_migrations_is_the_folder() {
    let folder = Migrator::new(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../migrations")).await.unwrap();
    let all = |migrator: &Migrator| {
        let row = |m: &Migration| (m.version, m.description.clone(), m.migration_type, m.checksum.clone(), m.no_tx);
        migrator.iter().map(row).collect::<Vec<_>>()
    };
    assert_eq!(all(&MIGRATIONS), all(&folder));
}

/// Checksums as earlier releases wrote them into their ledgers, which this one must open.
#[test]
fn released_migrations_have_the_checksums_of_their_release() {
    let released = include_str!("../released_migrations.txt");
    let hex = |bytes: &[u8]| bytes.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
    let own: Vec<_> =
        MIGRATIONS.iter().map(|m| format!("{} {} {}", m.version, hex(&m.checksum), m.description)).collect();
    let released: Vec<_> = released.lines().collect();
    assert_eq!(own[..released.len()], released);
}

#[tokio::test]
async fn a_newer_ledger_is_refused_with_what_to_do_and_stays_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("nestd.db");
    Ledger::open(&path).await.unwrap().close().await;
    let pool = raw(&path).await;
    let newer = "INSERT INTO _sqlx_migrations SELECT 99, description, installed_on, success, checksum, 0 FROM _sqlx_migrations LIMIT 1";
    sqlx::query(newer).execute(&pool).await.unwrap();
    sqlx::query("CREATE TABLE of_the_future (x)").execute(&pool).await.unwrap();
    let before = sqlx::query("SELECT * FROM _sqlx_migrations").fetch_all(&pool).await.unwrap().len();
    pool.close().await;
    let refused = Ledger::open_checked(&path).await.unwrap_err().to_string();
    assert!(refused.contains("has schema 99") && refused.contains("use the newer nestd"), "{refused}");
    let pool = raw(&path).await;
    let after = sqlx::query("SELECT count(*) FROM _sqlx_migrations").fetch_one(&pool).await.unwrap();
    assert_eq!(after.get::<i64, _>(0) as usize, before);
}
