//! A connection that is dead without having ended, or that somebody has forgotten, holds what all changes wait for.

use std::time::{Duration, Instant};

use super::*;
use crate::{
    postgres_cluster::PostgresCluster,
    server_link::{LinkState, ServerLink},
};

const LEASE: Duration = Duration::from_secs(60);
/// A frozen farm is one that did not go on within this time.
const FROZEN: Duration = Duration::from_secs(40);

fn node(name: &str) -> ServingNode {
    ServingNode { right: ServingRight::Node(name.to_owned()), owner: name.to_owned(), lease: LEASE }
}

#[tokio::test]
async fn a_node_that_is_cut_off_in_a_change_keeps_the_others_from_theirs_for_seconds() {
    let server = crate::postgres_cluster::shared();
    let database = server.make_database(None).await;
    let link = ServerLink::to_server(server.folder());
    let dead = LedgerAddress::parse(&PostgresCluster::url_in(link.folder(), &database), None);
    let direct = LedgerAddress::parse(&server.url(&database), None);
    let dead = Ledger::open_to_serve(&dead, &node("print1")).await.unwrap();
    let other = Ledger::open_to_serve(&direct, &node("print2")).await.unwrap();
    let person = Ledger::open_existing(&direct).await.unwrap();
    let change = dead.begin_change().await.unwrap();
    link.set(LinkState::Silent);
    let began = Instant::now();
    // The daemon tries again, and says why it waits; the command of a person waits until it is its turn.
    let waits = async {
        loop {
            match other.write_event(EventKind::Paused, "fuse-1", None, None, "").await {
                Ok(()) => break,
                Err(LedgerError::Server(ServerError::ChangesWait { holder })) => {
                    // On a slow machine the person's command, whose turn came first, may be at its change, or just have ended it.
                    let is_dead_node = holder.contains("print1") && holder.contains("idle in transaction");
                    assert!(is_dead_node || holder.contains("a command on") || holder == "many others", "{holder}")
                }
                Err(error) => panic!("{error}"),
            }
        }
    };
    let both = async { tokio::join!(waits, person.write_event(EventKind::Resumed, "fuse-1", None, None, "")) };
    let ((), told) = tokio::time::timeout(FROZEN, both).await.expect("all changes wait for a dead node");
    told.unwrap();
    assert!(began.elapsed() < Duration::from_secs(20), "{:?}", began.elapsed());
    drop(change);
}

#[tokio::test]
async fn a_table_that_somebody_keeps_locked_is_told_as_that_and_not_as_a_server_that_is_down() {
    let server = crate::postgres_cluster::shared();
    let database = server.make_database(None).await;
    let url = server.url(&database);
    let daemon = Ledger::open_to_serve(&LedgerAddress::parse(&url, None), &node("print1")).await.unwrap();
    let mut other = <sqlx::PgConnection as sqlx::Connection>::connect(&url).await.unwrap();
    sqlx::raw_sql("BEGIN; LOCK TABLE event IN ACCESS EXCLUSIVE MODE").execute(&mut other).await.unwrap();
    let ended = daemon.write_event(EventKind::Paused, "fuse-1", None, None, "").await.unwrap_err();
    assert!(
        matches!(&ended, LedgerError::Server(ServerError::ChangesWait { holder }) if holder.contains("pg_locks")),
        "{ended}"
    );
    sqlx::Connection::close(other).await.unwrap();
    daemon.write_event(EventKind::Paused, "fuse-1", None, None, "").await.unwrap();
}

#[tokio::test]
async fn what_is_asked_of_a_server_that_has_fallen_silent_ends_with_an_error_and_the_ledger_goes_on() {
    let server = crate::postgres_cluster::shared();
    let database = server.make_database(None).await;
    let link = ServerLink::to_server(server.folder());
    let address = LedgerAddress::parse(&PostgresCluster::url_in(link.folder(), &database), None);
    let daemon = Ledger::open_to_serve(&address, &node("print1")).await.unwrap();
    let is_told = |ended: LedgerError| matches!(ended, LedgerError::Server(ServerError::Unreachable(_)));
    // A statement, a commit, and as many reads as there are connections left.
    let mut asked = daemon.begin_change().await.unwrap();
    let mut reads = Vec::new();
    for _ in 0..2 {
        reads.push(daemon.begin_snapshot().await.unwrap());
    }
    link.set(LinkState::Forgotten);
    let began = Instant::now();
    let all = async {
        assert!(is_told(asked.write_event(EventKind::Paused, "fuse-1", None, None, "").await.unwrap_err()));
        for mut read in reads {
            let ended = sql::query_scalar::<i64>("SELECT count(*) FROM part").fetch_one(&mut read);
            // One is enough to know; the others are dropped as they are.
            if began.elapsed() < Duration::from_secs(21) {
                assert!(is_told(ended.await.unwrap_err().into()));
            }
        }
    };
    tokio::time::timeout(Duration::from_secs(60), all).await.expect("nobody is told");
    drop(asked);
    assert!(!matches!(daemon.service_state(), ServiceState::TakenOver), "{:?}", daemon.service_state());
    let began = Instant::now();
    while let Err(error) = daemon.write_event(EventKind::Paused, "fuse-1", None, None, "").await {
        assert!(began.elapsed() < Duration::from_secs(25), "{error}");
    }
    let change = daemon.begin_change().await.unwrap();
    link.set(LinkState::Forgotten);
    let commit = tokio::time::timeout(Duration::from_secs(30), change.commit()).await;
    assert!(is_told(commit.expect("a commit waits for ever").unwrap_err()));
}

#[tokio::test]
async fn each_connection_has_limits_and_a_transfer_of_all_rows_has_its_own() {
    let address = fresh_address().await;
    let daemon = Ledger::open_to_serve(&address, &node("print1")).await.unwrap();
    let person = Ledger::open_existing(&address).await.unwrap();
    let setting = async |db: &mut sql::SqlTransaction, name: &str| {
        let setting = sql::query_scalar::<String>("SELECT current_setting($1)").bind(name);
        setting.fetch_one(db).await.unwrap()
    };
    let mut change = daemon.begin_change().await.unwrap();
    assert_eq!(setting(change.db(), "application_name").await, "print1");
    assert_eq!(setting(change.db(), "idle_in_transaction_session_timeout").await, "10s");
    assert_eq!(setting(change.db(), "statement_timeout").await, "15s");
    drop(change);
    let mut snapshot = person.begin_snapshot().await.unwrap();
    assert!(setting(&mut snapshot, "application_name").await.starts_with("a command on "));
    assert_eq!(setting(&mut snapshot, "statement_timeout").await, "1min");
    snapshot.allow_whole_ledger().await.unwrap();
    assert_eq!(setting(&mut snapshot, "statement_timeout").await, "6h");
    assert_eq!(setting(&mut snapshot, "idle_in_transaction_session_timeout").await, "10min");
}
