//! The same random operations on both databases: each answers alike, and afterwards all tables and views hold the same
//! rows.

use std::{
    collections::BTreeSet,
    sync::{
        Arc,
        atomic::{AtomicI64, Ordering},
    },
};

use jiff::SignedDuration;
use proptest::{
    strategy::{Strategy, ValueTree},
    test_runner::{Config, RngAlgorithm, TestRng, TestRunner},
};

use super::*;
use crate::tests::store::random_walks::{RandomWalk, is_refusal, step};

/// Walks, and the steps of each.
const WALKS: usize = 3;
const STEPS: usize = 150;

/// All tables and views, except those of the databases' own bookkeeping.
pub(super) async fn relations(ledger: &Ledger) -> Vec<String> {
    let text = "SELECT name FROM sqlite_schema WHERE type IN ('table', 'view') AND name NOT LIKE 'sqlite_%' \
                AND name NOT IN ('_sqlx_migrations', 'change_count')";
    sql::query_scalar(text).fetch_all(ledger.reader().unwrap()).await.unwrap()
}

/// Tables whose numbers nothing else refers to. A change that fails takes numbers with it on PostgreSQL and not on SQLite, so
/// that their order is the same and they are not.
const NUMBERED_WITH_GAPS: [&str; 5] = ["event", "ticket", "outcome", "command", "pick_mark"];

/// The rows of a table or view as text.
async fn rows_of(ledger: &Ledger, relation: &str) -> BTreeSet<String> {
    let has_gaps = NUMBERED_WITH_GAPS.contains(&relation);
    let order = if has_gaps { "ORDER BY id" } else { "" };
    let query = sql::query_whole_rows(sqlx::AssertSqlSafe(format!("SELECT * FROM {relation} {order}")));
    let rows = query.fetch_all(ledger.reader().unwrap()).await.unwrap_or_else(|error| panic!("{relation}: {error}"));
    let text = |(place, mut row): (u32, Vec<(String, SqlValue)>)| {
        row.sort_by(|a, b| a.0.cmp(&b.0));
        if has_gaps {
            row.iter_mut().filter(|(name, _)| name == "id").for_each(|(_, id)| *id = place.to_sql());
        }
        row.into_iter()
            .map(|(name, value)| format!("{name}: {}", comparable(&name, value)))
            .collect::<Vec<_>>()
            .join(", ")
    };
    (0_u32..).zip(rows).map(text).collect()
}

/// A value as both databases give it. The builds of a part are a set.
fn comparable(column: &str, value: SqlValue) -> String {
    match value {
        SqlValue::Flag(Some(flag)) => i64::from(flag).to_string(),
        SqlValue::Text(Some(list)) if column == "builds" => {
            list.split(',').map(str::to_owned).collect::<BTreeSet<_>>().into_iter().collect::<Vec<_>>().join(",")
        }
        other => other.into_json().to_string(),
    }
}

pub(super) async fn compare(file: &Ledger, server: &Ledger, relations: &[String], after: &str) {
    for relation in relations {
        let (one, other) = (rows_of(file, relation).await, rows_of(server, relation).await);
        let differ: Vec<_> = one.symmetric_difference(&other).collect();
        assert!(differ.is_empty(), "{relation} differs after {after}: {differ:#?}");
    }
}

#[tokio::test]
async fn the_same_operations_leave_the_same_rows_on_both() {
    let config = Config { failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let (mut done, mut refused) = (0, 0);
    for _ in 0..WALKS {
        let (file, server) = both().await;
        let relations = relations(&file).await;
        assert!(relations.len() > 15, "{relations:?}");
        // Each step takes a second, on both.
        let clock = Arc::new(AtomicI64::new(0));
        let with_clock = |ledger: &Ledger| {
            let (clock, start) = (clock.clone(), at("2026-11-20T04:49:00Z"));
            ledger.clone().with_clock(move || start + SignedDuration::from_secs(clock.load(Ordering::SeqCst)))
        };
        let (file_of, server_of) = (with_clock(&file), with_clock(&server));
        let (mut on_file, mut on_server) = (RandomWalk::default(), RandomWalk::default());
        for n in 0..STEPS {
            clock.fetch_add(1, Ordering::SeqCst);
            let step = step().new_tree(&mut runner).unwrap().current();
            let one = on_file.take(&file_of, step.clone()).await;
            let other = on_server.take(&server_of, step.clone()).await;
            assert_eq!(format!("{one:?}"), format!("{other:?}"), "{step:?}");
            match one {
                Ok(()) => done += 1,
                Err(error) => {
                    assert!(is_refusal(&error), "{step:?}: {error:?}");
                    refused += 1;
                }
            }
            compare(&file, &server, &relations, &format!("step {n}, {step:?}")).await;
        }
    }
    assert!(done > 100 && refused > 50, "{done} steps were done, {refused} refused");
}
