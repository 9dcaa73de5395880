//! A large ledger from before orders were kept is upgraded in a short time and answers as fast as a new one.
//!
//! `cargo test --release --lib upgrade -- --ignored --nocapture` upgrades a million builds.

use std::{borrow::Cow, io::Write, path::Path, time::Instant};

use sqlx::{SqlitePool, migrate::Migrator, sqlite::SqliteConnectOptions};

use crate::{store::schema::MIGRATIONS, tests::*};

#[path = "../../../../../tests/reliability/load/large_ledger.rs"]
#[expect(dead_code, reason = "the reliability run uses the rest")]
mod large_ledger;

/// The first schema with orders.
const ORDERS: i64 = 18;
/// Parts of each order.
const PARTS_OF_AN_ORDER: u64 = 10;

/// Makes a ledger of the schema before orders were kept, with so many builds; every part belongs to an order.
async fn make_earlier_ledger(path: &Path, builds: u64) {
    let options = SqliteConnectOptions::new().filename(path).create_if_missing(true);
    let pool = SqlitePool::connect_with(options).await.unwrap();
    let earlier: Vec<_> = MIGRATIONS.iter().filter(|migration| migration.version < ORDERS).cloned().collect();
    Migrator { migrations: Cow::Owned(earlier), ..Migrator::DEFAULT }.run(&pool).await.unwrap();
    large_ledger::fill_published(path, builds).await;
    let orders = format!(
        "UPDATE part SET order_name = printf('Order-%d', id / {PARTS_OF_AN_ORDER}); \
         UPDATE build SET state = 'published' WHERE id > {builds} - 100"
    );
    sqlx::raw_sql(sqlx::AssertSqlSafe(orders)).execute(&pool).await.unwrap();
    pool.close().await;
}

/// Seconds of an upgrade.
struct UpgradeTimes {
    upgrade: f64,
    status: f64,
    orders: f64,
    show: f64,
}

/// Upgrades a ledger of so many builds and asks it what people ask.
async fn upgrade(builds: u64) -> UpgradeTimes {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("nestd.db");
    make_earlier_ledger(&path, builds).await;
    let secs = |began: Instant| began.elapsed().as_secs_f64();
    let began = Instant::now();
    let ledger = Ledger::open(&path).await.unwrap();
    let upgrade = secs(began);
    let began = Instant::now();
    ledger.machine_statuses().await.unwrap();
    let status = secs(began);
    let began = Instant::now();
    let open = ledger.order_summaries(&OrderQuery { limit: 50, ..OrderQuery::default() }).await.unwrap();
    let orders = secs(began);
    assert!(open.len() >= 10 && open[..10].iter().all(|order| order.order.state == OrderState::Open));
    let began = Instant::now();
    let lines = ledger.order_lines("Order-7").await.unwrap();
    let show = secs(began);
    assert_eq!(lines.len() as u64, PARTS_OF_AN_ORDER);
    assert!(lines.iter().all(|line| (line.copies.wanted, line.copies.good) == (2, 2)));
    assert_eq!(ledger.find_order("Order-7").await.unwrap().unwrap().state, OrderState::Complete);
    let found = OrderQuery { name: Some("order-7".to_owned()), limit: 5, ..OrderQuery::default() };
    assert!(!ledger.list_orders(&found).await.unwrap().is_empty());
    UpgradeTimes { upgrade, status, orders, show }
}

#[tokio::test]
async fn the_copies_of_a_line_are_counted_from_its_placements_and_not_from_all_builds_of_a_state() {
    let ledger = fresh().await;
    let plan = "EXPLAIN QUERY PLAN SELECT * FROM v_order_line WHERE order_name = 'a' AND order_name <> ''";
    let pool = SqlitePool::connect_with(SqliteConnectOptions::new().filename(ledger.file().unwrap())).await.unwrap();
    let steps: Vec<(i64, i64, i64, String)> = sqlx::query_as(plan).fetch_all(&pool).await.unwrap();
    let of_builds: Vec<&str> = steps.iter().map(|step| step.3.as_str()).filter(|step| step.contains(" b ")).collect();
    assert!(!of_builds.is_empty());
    assert!(of_builds.iter().all(|step| step.contains("INTEGER PRIMARY KEY")), "{of_builds:#?}");
}

#[tokio::test]
async fn a_ledger_of_many_builds_from_before_orders_is_upgraded_at_once() {
    let times = upgrade(20_000).await;
    // It takes about 5 CPU seconds; a busy machine needs longer for them.
    assert!(times.upgrade < 60.0, "{} s for 20,000 builds", times.upgrade);
}

#[tokio::test]
#[ignore = "takes minutes: a ledger of a million builds is made"]
async fn a_ledger_of_a_million_builds_from_before_orders_is_upgraded_within_a_minute() {
    let times = upgrade(1_000_000).await;
    let peak = std::fs::read_to_string("/proc/self/status").unwrap();
    let peak = peak.lines().find(|line| line.starts_with("VmHWM")).unwrap_or_default();
    let report = format!(
        "upgrade {:.1} s, status {:.3} s, 50 orders {:.3} s, one order {:.3} s, {peak}",
        times.upgrade, times.status, times.orders, times.show
    );
    writeln!(std::io::stdout(), "{report}").unwrap();
    assert!(times.upgrade < 60.0 && times.status < 1.0 && times.orders < 1.0 && times.show < 1.0);
}
