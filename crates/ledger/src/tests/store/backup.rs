//! Tests of backups: consistent during writes, complete or absent, and never overwriting another file.

use std::{fs, os::unix::fs::PermissionsExt};

use crate::tests::*;

#[tokio::test]
async fn a_backup_is_a_whole_ledger_with_its_seal_and_for_its_owner_only() {
    let ledger = fresh().await;
    let part = waiting(&ledger, "a", 2).await;
    let build = published(&ledger, &[(part, 0), (part, 1)]).await;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ledger.backup");
    let bytes = ledger.write_backup(&file).await.unwrap();
    assert_eq!(fs::metadata(&file).unwrap().len(), bytes);
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
    let names: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(names.len(), 2, "the backup and its seal: {names:?}");
    crate::prove_backup(&file).await.unwrap();
    let copy = Ledger::open_checked(&file).await.unwrap();
    assert_eq!(build_state(&copy, build).await, BuildState::Published);
    assert_eq!(copy.find_inconsistencies().await.unwrap(), Vec::<String>::new());
}

#[tokio::test]
async fn a_backup_overwrites_nothing_and_leaves_nothing_behind_when_it_fails() {
    let ledger = fresh().await;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("precious");
    fs::write(&file, "mine").unwrap();
    let refused = ledger.write_backup(&file).await.unwrap_err().to_string();
    assert!(refused.contains("is there already"), "{refused}");
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    assert!(ledger.write_backup(&folder.path().join("no/such/folder/ledger")).await.is_err());
}

#[tokio::test]
async fn a_damaged_or_foreign_backup_is_distinguished_from_a_good_one() {
    let ledger = fresh().await;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("backup");
    ledger.write_backup(&file).await.unwrap();
    let whole = fs::read(&file).unwrap();
    for at in [18, 200, whole.len() / 2, whole.len() - 1] {
        let mut bytes = whole.clone();
        bytes[at] ^= 1;
        fs::write(&file, bytes).unwrap();
        assert!(crate::prove_backup(&file).await.unwrap_err().is_damage(), "byte {at}");
    }
    fs::write(&file, "SELECT 1").unwrap();
    assert!(crate::prove_backup(&file).await.unwrap_err().is_damage());
    let other = folder.path().join("other.db");
    let pool = sqlx::SqlitePool::connect(&format!("sqlite:{}?mode=rwc", other.display())).await.unwrap();
    sqlx::query("CREATE TABLE x (y)").execute(&pool).await.unwrap();
    pool.close().await;
    let refused = crate::prove_backup(&other).await.unwrap_err().to_string();
    assert!(refused.contains("holds no ledger"), "{refused}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_backup_while_somebody_writes_holds_a_moment_of_the_ledger() {
    let ledger = fresh().await;
    let writer = ledger.ledger.clone();
    let writes = tokio::spawn(async move {
        for n in 0..80 {
            let part = waiting(&writer, &format!("part-{n}"), 2).await;
            published(&writer, &[(part, 0), (part, 1)]).await;
        }
    });
    let folder = tempfile::tempdir().unwrap();
    let mut last = 0;
    for n in 0.. {
        let ended = writes.is_finished();
        let file = folder.path().join(n.to_string());
        ledger.write_backup(&file).await.unwrap();
        let copy = Ledger::open_existing(&file).await.unwrap();
        assert_eq!(copy.find_inconsistencies().await.unwrap(), Vec::<String>::new());
        let builds = copy.read_history(&HistoryQuery::default()).await.unwrap().len();
        assert!(builds >= last, "an acknowledged build is missing");
        last = builds;
        if ended {
            break;
        }
    }
    assert_eq!(last, 80);
    writes.await.unwrap();
}
