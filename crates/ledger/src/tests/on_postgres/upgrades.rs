//! Nodes are upgraded one after the other: what a newer nestd adds to the schema is of no concern to older ones, and what they could not
//! use is refused while they run.

use std::time::Duration;

use proptest::{
    strategy::{Strategy, ValueTree},
    test_runner::{Config, RngAlgorithm, TestRng, TestRunner},
};

use super::*;
use crate::{
    keep::copy::TABLES,
    store::{address::ServerAddress, postgres::upgrade_as_newer},
    tests::store::random_walks::{RandomWalk, is_refusal, step},
};

const LONG: Duration = Duration::from_secs(60);

async fn start(address: &LedgerAddress, name: &str) -> Result<Ledger, LedgerError> {
    let right = ServingRight::Node(name.to_owned());
    Ledger::open_to_serve(address, &ServingNode { right, owner: name.to_owned(), lease: LONG }).await
}

fn server(address: &LedgerAddress) -> &ServerAddress {
    let LedgerAddress::Server(server) = address else { panic!("{address}") };
    server
}

/// A migration that adds a column to every table.
fn additions(version: i64) -> &'static str {
    let add = |table: &str| format!("ALTER TABLE {table} ADD COLUMN of_{version} TEXT NOT NULL DEFAULT 'later';\n");
    TABLES.iter().map(|table| add(table.name)).collect::<String>().leak()
}

#[tokio::test]
async fn a_node_goes_on_and_starts_again_while_newer_ones_add_to_the_schema() {
    let address = fresh_address().await;
    let ledger = start(&address, "print1").await.unwrap();
    let other = start(&address, "print2").await.unwrap();
    let config = Config { failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let (mut walk, mut done, mut added) = (RandomWalk::default(), 0, Vec::new());
    for n in 0..240 {
        if n % 60 == 59 {
            // The statements of both nodes are prepared.
            added.push((9000 + n, additions(9000 + n), true));
            upgrade_as_newer(server(&address), &added).await.unwrap();
        }
        let step = step().new_tree(&mut runner).unwrap().current();
        match walk.take(&ledger, step.clone()).await {
            Ok(()) => done += 1,
            Err(error) => assert!(is_refusal(&error), "{step:?}: {error:?}"),
        }
        walk.account(&other).await;
    }
    assert!(done > 50, "{done} steps");
    assert_eq!(other.find_inconsistencies().await.unwrap(), Vec::<String>::new());
    ledger.close().await;
    let again = start(&address, "print1").await.unwrap();
    walk.account(&again).await;
    walk.account(&Ledger::open_existing(&address).await.unwrap()).await;
    // A copy would lack what it does not know.
    let refused = again.copy_into_ledger(&fresh_file().await.ledger, ExistingRows::Refuse).await.unwrap_err();
    assert!(refused.to_string().contains("newer"), "{refused}");
}

#[tokio::test]
async fn what_older_nodes_could_not_use_waits_until_they_have_ended() {
    let address = fresh_address().await;
    let older = start(&address, "print1").await.unwrap();
    let breaking = (9001, "ALTER TABLE part RENAME COLUMN note TO remark", false);
    let refused = upgrade_as_newer(server(&address), &[breaking]).await.unwrap_err();
    assert!(
        matches!(&refused, LedgerError::Server(ServerError::OlderNodes { nodes }) if nodes == "node print1 (print1)"),
        "{refused}"
    );
    waiting(&older, "a", 1).await;
    older.close().await;
    upgrade_as_newer(server(&address), &[breaking]).await.unwrap();
    let refused = start(&address, "print1").await.unwrap_err();
    assert!(matches!(refused, LedgerError::NewerSchema { found: 9001, .. }), "{refused}");
    let refused = Ledger::open_existing(&address).await.unwrap_err();
    assert!(matches!(refused, LedgerError::NewerSchema { .. }), "{refused}");
}

#[tokio::test]
async fn an_older_node_that_slept_during_the_migration_changes_nothing_more() {
    let address = fresh_address().await;
    let older = start(&address, "print1").await.unwrap();
    let viewer = Ledger::open_existing(&address).await.unwrap();
    let mut change = viewer.begin_change().await.unwrap();
    sql::query("UPDATE lease SET until = clock_timestamp()").execute(change.db()).await.unwrap();
    change.commit().await.unwrap();
    let breaking = (9001, "ALTER TABLE part RENAME COLUMN note TO remark", false);
    upgrade_as_newer(server(&address), &[breaking]).await.unwrap();
    let late = older.write_event(EventKind::Paused, "", None, None, "").await.unwrap_err();
    assert!(matches!(late, LedgerError::Server(ServerError::TakenOver)), "{late}");
}

#[tokio::test]
async fn a_schema_does_not_change_under_a_copy_and_not_half() {
    let address = fresh_address().await;
    let right = ServingRight::WholeLedger;
    let copies = ServingNode { right, owner: "nestd ledger copy".to_owned(), lease: LONG };
    let copying = Ledger::open_to_serve(&address, &copies).await.unwrap();
    let refused = upgrade_as_newer(server(&address), &[(9001, additions(9001), true)]).await.unwrap_err();
    assert!(refused.to_string().contains("nestd ledger copy"), "{refused}");
    copying.close().await;
    let half = "ALTER TABLE part ADD COLUMN of_9001 TEXT; SELECT 1 / 0;";
    assert!(upgrade_as_newer(server(&address), &[(9001, half, true)]).await.is_err());
    upgrade_as_newer(server(&address), &[(9001, additions(9001), true)]).await.unwrap();
}

#[tokio::test]
async fn a_migration_does_not_keep_the_farm_waiting_for_one_who_reads_for_long() {
    let address = fresh_address().await;
    let ledger = start(&address, "print1").await.unwrap();
    let part = waiting(&ledger, "a", 1).await;
    let mut dump = ledger.begin_snapshot().await.unwrap();
    dump.allow_whole_ledger().await.unwrap();
    sql::query_scalar::<i64>("SELECT count(*) FROM part").fetch_one(&mut dump).await.unwrap();
    let refused = upgrade_as_newer(server(&address), &[(9001, additions(9001), true)]).await.unwrap_err();
    assert!(refused.to_string().contains("pg_dump"), "{refused}");
    assert!(ledger.find_part(part).await.unwrap().is_some());
    drop(dump);
    upgrade_as_newer(server(&address), &[(9001, additions(9001), true)]).await.unwrap();
    waiting(&ledger, "b", 1).await;
}
