//! How many connections a process makes, with which password, and what it says where it gets none.

use std::{
    fs::Permissions,
    os::unix::fs::PermissionsExt,
    path::Path,
    time::{Duration, Instant},
};

use sqlx::{AssertSqlSafe, PgConnection};

use super::*;
use crate::{LedgerUser, postgres_cluster::PostgresCluster};

const LEASE: Duration = Duration::from_secs(60);
const FIRST: &str = "the first password of the farm";
const SECOND: &str = "the second password of the farm";

fn write_secret(file: &Path, secret: &str) {
    std::fs::write(file, secret).unwrap();
    std::fs::set_permissions(file, Permissions::from_mode(0o600)).unwrap();
}

/// A server that asks the user `farm` for a password, and the address of a ledger of that user.
async fn guarded(password: &Path) -> (PostgresCluster, PgConnection, LedgerAddress) {
    let server = PostgresCluster::start();
    let database = server.make_database(None).await;
    let mut admin = server.connect(&database).await;
    run(&mut admin, &format!("CREATE ROLE farm LOGIN PASSWORD '{FIRST}'")).await;
    run(&mut admin, &format!("ALTER DATABASE {database} OWNER TO farm")).await;
    run(&mut admin, "ALTER SCHEMA public OWNER TO farm").await;
    server.demand_password("farm");
    run(&mut admin, "SELECT pg_reload_conf()").await;
    let url = server.url(&database).replace("nestd@", "farm@");
    (server, admin, LedgerAddress::parse(&url, Some(password)))
}

async fn run(admin: &mut PgConnection, statement: &str) {
    sqlx::query(AssertSqlSafe(statement.to_owned())).execute(admin).await.unwrap();
}

async fn connections_of(admin: &mut PgConnection, name: &str) -> i64 {
    let count = sqlx::query_scalar("SELECT count(*) FROM pg_stat_activity WHERE application_name LIKE $1").bind(name);
    count.fetch_one(admin).await.unwrap()
}

#[tokio::test]
async fn a_changed_password_is_taken_from_its_file_without_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("password");
    write_secret(&file, FIRST);
    let (_server, mut admin, address) = guarded(&file).await;
    let node = ServingNode { right: ServingRight::Node("print1".to_owned()), owner: "print1".to_owned(), lease: LEASE };
    let daemon = Ledger::open_to_serve(&address, &node).await.unwrap();
    run(&mut admin, &format!("ALTER ROLE farm PASSWORD '{SECOND}'")).await;
    run(&mut admin, "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE usename = 'farm'").await;
    let told = loop {
        match daemon.write_event(EventKind::Paused, "fuse-1", None, None, "").await {
            Err(error) if error.to_string().contains("password") => break error.to_string(),
            Err(_) => {}
            Ok(()) => panic!("the old password is good for new connections"),
        }
    };
    assert!(told.contains("does not let nestd in") && told.contains("ledger_password_file"), "{told}");
    write_secret(&file, SECOND);
    let began = Instant::now();
    while let Err(error) = daemon.write_event(EventKind::Paused, "fuse-1", None, None, "").await {
        assert!(began.elapsed() < Duration::from_secs(10), "{error}");
    }
}

#[tokio::test]
async fn who_gets_no_connection_is_told_that_all_are_in_use() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("password");
    write_secret(&file, FIRST);
    let (_server, mut admin, address) = guarded(&file).await;
    Ledger::open(&address).await.unwrap().close().await;
    run(&mut admin, "ALTER ROLE farm CONNECTION LIMIT 2").await;
    let first = Ledger::open_existing(&address).await.unwrap();
    let _reads = (first.begin_snapshot().await.unwrap(), first.begin_snapshot().await.unwrap());
    let told = Ledger::open_existing(&address).await.unwrap_err().to_string();
    assert!(told.contains("all its connections are in use") && told.contains("node.connections"), "{told}");
}

#[tokio::test]
async fn a_daemon_its_pages_and_a_command_make_no_more_connections_than_they_may() {
    let server = PostgresCluster::start();
    let database = server.make_database(None).await;
    let address = LedgerAddress::parse(&server.url(&database), None).with_connections(6);
    let node = ServingNode { right: ServingRight::Node("print1".to_owned()), owner: "print1".to_owned(), lease: LEASE };
    let daemon = Ledger::open_to_serve(&address, &node).await.unwrap();
    let pages = Ledger::open_existing_for(&address, LedgerUser::Pages).await.unwrap();
    let monitoring = Ledger::open_existing_for(&address, LedgerUser::Monitoring).await.unwrap();
    let command = Ledger::open_existing(&address).await.unwrap();
    for ledger in [&daemon, &pages, &monitoring, &command] {
        let reads = (0..20).map(|_| {
            let ledger = ledger.clone();
            tokio::spawn(async move { ledger.machine_statuses().await.unwrap() })
        });
        for read in reads.collect::<Vec<_>>() {
            read.await.unwrap();
        }
    }
    let mut admin = server.connect(&database).await;
    assert_eq!(connections_of(&mut admin, "print1").await, 3);
    assert_eq!(connections_of(&mut admin, "the pages on %").await, 2);
    assert_eq!(connections_of(&mut admin, "metrics and messages on %").await, 1);
    assert_eq!(connections_of(&mut admin, "a command on %").await, 2);
}

#[tokio::test]
async fn a_daemon_is_told_of_the_changes_of_its_machines_and_of_those_that_concern_all() {
    let address = fresh_address().await;
    let node = ServingNode { right: ServingRight::Node("print1".to_owned()), owner: "print1".to_owned(), lease: LEASE };
    let daemon = Ledger::open_to_serve(&address, &node).await.unwrap();
    let person = Ledger::open_existing(&address).await.unwrap();
    let told = || daemon.told_changes(["fuse-1"]);
    let wait_for = async |what: &str, is_so: &dyn Fn() -> bool| {
        let began = Instant::now();
        while !is_so() {
            assert!(began.elapsed() < Duration::from_secs(10), "{what}: {:?}", told());
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    };
    wait_for("it listens", &|| told().is_some()).await;
    let before = told().unwrap();
    person.write_event(EventKind::Paused, "other", None, None, "").await.unwrap();
    person.write_event(EventKind::Paused, "fuse-1", None, None, "").await.unwrap();
    wait_for("a change of its machine", &|| told() == Some(before + 1)).await;
    person.write_event(EventKind::ClockSet, "", None, None, "").await.unwrap();
    wait_for("a change of all", &|| told() == Some(before + 2)).await;
}
