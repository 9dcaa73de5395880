//! Tests of opening a ledger, and of two processes that write at the same time.

use crate::{base::sql, tests::*};
use std::{path::Path, process, time::Duration};

/// Number of changes that each of two concurrent writers makes.
const CHANGES: usize = 60;
/// Environment variable with the path of the ledger for the second process of a test.
const LEDGER: &str = "NESTD_TEST_LEDGER";

#[tokio::test]
async fn a_ledger_is_made_with_its_folder_and_opened_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state/nestd.db");
    let missing = Ledger::open_existing(&path).await.unwrap_err();
    assert!(missing.to_string().contains("there is no ledger at"), "{missing}");
    let ledger = Ledger::open(&path).await.unwrap();
    let id = waiting(&ledger, "a", 1).await;
    ledger.close().await;
    let again = Ledger::open_existing(&path).await.unwrap();
    assert_eq!(part_state(&again, id).await, PartState::Waiting);
    assert_eq!(again.file().unwrap(), path);
    let mode: String = sql::query_scalar("PRAGMA journal_mode").fetch_one(again.reader().unwrap()).await.unwrap();
    assert_eq!(mode, "wal");
    let mut change = again.begin_change().await.unwrap();
    let full: i64 = sql::query_scalar("PRAGMA synchronous").fetch_one(change.db()).await.unwrap();
    let keys: i64 = sql::query_scalar("PRAGMA foreign_keys").fetch_one(change.db()).await.unwrap();
    assert_eq!((full, keys), (2, 1), "synchronous = FULL, foreign keys on");
}

#[tokio::test]
async fn a_reader_cannot_write() {
    let ledger = fresh().await;
    let written = sql::query("DELETE FROM pause").execute(ledger.reader().unwrap()).await.unwrap_err();
    assert!(matches!(LedgerError::from(written), LedgerError::ReadOnly));
}

#[tokio::test]
async fn a_ledger_of_another_schema_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("nestd.db");
    let ledger = Ledger::open(&path).await.unwrap();
    let mut change = ledger.begin_change().await.unwrap();
    let newer = "INSERT INTO _sqlx_migrations SELECT 9999, description, installed_on, success, checksum, 0 \
                 FROM _sqlx_migrations LIMIT 1";
    sql::query(newer).execute(change.db()).await.unwrap();
    change.commit().await.unwrap();
    for refused in [Ledger::open(&path).await, Ledger::open_existing(&path).await] {
        assert!(matches!(refused, Err(LedgerError::NewerSchema { found: 9999, .. })), "{refused:?}");
    }
    let mut change = ledger.begin_change().await.unwrap();
    sql::query("DELETE FROM _sqlx_migrations").execute(change.db()).await.unwrap();
    change.commit().await.unwrap();
    assert!(matches!(Ledger::open_existing(&path).await, Err(LedgerError::OlderSchema { found: 0, .. })));
}

#[tokio::test]
async fn a_file_that_is_no_database_is_refused_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("nestd.db");
    let text = "solid cube\n".repeat(200);
    std::fs::write(&path, &text).unwrap();
    assert!(matches!(Ledger::open(&path).await, Err(LedgerError::Damaged { .. })));
    assert!(matches!(Ledger::open_existing(&path).await, Err(LedgerError::Damaged { .. })));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
}

#[tokio::test]
async fn a_change_that_is_dropped_half_way_leaves_nothing_behind() {
    let ledger = fresh().await;
    let mut kept = 0;
    for micros in (0..3_000).step_by(25) {
        let part = new_part(&format!("dropped-{micros}"), 1);
        let claim = ledger.record_claim(&part);
        kept += usize::from(tokio::time::timeout(Duration::from_micros(micros), claim).await.is_ok());
    }
    ledger.record_claim(&new_part("last", 1)).await.unwrap();
    let claimed = ledger.parts_in_state(PartState::Claimed).await.unwrap().len();
    assert!(claimed > kept, "{claimed} of {kept}: what was acknowledged is there");
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), Vec::<String>::new());
}

/// Reads, then writes: with a deferred BEGIN these fail with "database is locked".
async fn write_much(path: &Path, who: &str) {
    let ledger = Ledger::open(path).await.unwrap();
    for n in 0..CHANGES {
        let id = waiting(&ledger, &format!("{who}-{n}"), 1).await;
        if n % 5 == 0 {
            ledger.cancel_part(id, RefusalCause::Cancelled, "enough").await.unwrap();
        }
        ledger.waiting_copies("paper-200").await.unwrap();
    }
    ledger.close().await;
}

/// The second process of the test below. Does nothing when run on its own.
#[tokio::test]
async fn a_second_process_writes_when_it_is_asked() {
    if let Some(path) = std::env::var_os(LEDGER) {
        write_much(Path::new(&path), "child").await;
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn processes_and_pools_that_write_at_once_never_see_a_locked_ledger() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("nestd.db");
    let mut child = process::Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "tests::store::opening::a_second_process_writes_when_it_is_asked"])
        .env(LEDGER, &path)
        .stdout(process::Stdio::null())
        .spawn()
        .unwrap();
    let (first, second) = (path.clone(), path.clone());
    let first = tokio::spawn(async move { write_much(&first, "first").await });
    let second = tokio::spawn(async move { write_much(&second, "second").await });
    first.await.unwrap();
    second.await.unwrap();
    assert!(child.wait().unwrap().success(), "the second process failed");
    let ledger = Ledger::open_existing(&path).await.unwrap();
    let all: i64 = sql::query_scalar("SELECT count(*) FROM part").fetch_one(ledger.reader().unwrap()).await.unwrap();
    assert_eq!(all as usize, 3 * CHANGES);
    assert_eq!(ledger.find_inconsistencies().await.unwrap(), Vec::<String>::new());
}
