//! Tests with ledgers that are damaged on purpose: the damage is detected, the ledger is refused, and its files are
//! kept.

use std::{fs, path::PathBuf};

use sqlx::{SqlitePool, sqlite::SqliteConnectOptions};
use tempfile::TempDir;

use super::*;
use crate::{Ledger, fixtures::*};

/// A ledger with some parts and builds that was closed in an orderly way.
async fn closed() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("nestd.db");
    let ledger = Ledger::open_checked(&path).await.unwrap();
    for n in 0..12 {
        let part = waiting(&ledger, &format!("part-{n}"), 2).await;
        published(&ledger, &[(part, 0), (part, 1)]).await;
    }
    assert!(ledger.close_with_checksum().await.unwrap());
    assert!(checksum_path(&path).exists() && !lost_changes::log_of(&path).exists());
    (folder, path)
}

/// The ledger's files as they are after the process is killed: the last changes are only in the write-ahead log. The
/// files are in a separate folder.
async fn killed() -> (TempDir, PathBuf) {
    let (from, path) = closed().await;
    let ledger = Ledger::open(&path).await.unwrap();
    waiting(&ledger, "only in the log", 2).await;
    let folder = tempfile::tempdir().unwrap();
    for file in ["nestd.db", "nestd.db-wal", "nestd.db-shm", "nestd.db-changes"] {
        fs::copy(from.path().join(file), folder.path().join(file)).unwrap();
    }
    let path = folder.path().join("nestd.db");
    (folder, path)
}

async fn refusal(path: &Path) -> String {
    let error = Ledger::open_checked(path).await.expect_err("a damaged ledger was opened");
    assert!(error.is_damage(), "{error}");
    assert!(error.to_string().contains("nestd restore"), "no remedy: {error}");
    error.to_string()
}

fn flip(file: &Path, at: usize) {
    let mut bytes = fs::read(file).unwrap();
    bytes[at] ^= 0x40;
    fs::write(file, bytes).unwrap();
}

#[tokio::test]
async fn a_ledger_that_was_closed_in_order_is_opened_again_and_its_seal_broken_by_the_first_change() {
    let (_folder, path) = closed().await;
    let ledger = Ledger::open_checked(&path).await.unwrap();
    waiting(&ledger, "another", 1).await;
    assert!(!checksum_path(&path).exists());
    assert!(ledger.close_with_checksum().await.unwrap());
    assert!(check_files(&path).await.unwrap(), "the seal vouches for it");
}

#[tokio::test]
async fn any_flipped_byte_of_a_sealed_ledger_is_noticed() {
    let (_folder, path) = closed().await;
    let bytes = fs::metadata(&path).unwrap().len() as usize;
    for at in (0..bytes).step_by(bytes / 50) {
        flip(&path, at);
        assert!(refusal(&path).await.contains("it changed since nestd shut down"));
        flip(&path, at);
    }
    Ledger::open_checked(&path).await.unwrap();
}

#[tokio::test]
async fn a_sealed_ledger_that_was_cut_emptied_removed_or_given_a_log_is_refused() {
    let (_folder, path) = closed().await;
    let whole = fs::read(&path).unwrap();
    for kept in [0, 100, 4096, whole.len() - 1] {
        fs::write(&path, &whole[..kept]).unwrap();
        refusal(&path).await;
    }
    fs::write(&path, &whole).unwrap();
    fs::write(lost_changes::log_of(&path), "some other log").unwrap();
    refusal(&path).await;
    fs::remove_file(lost_changes::log_of(&path)).unwrap();
    fs::remove_file(&path).unwrap();
    assert!(check_files(&path).await.is_err());
}

#[tokio::test]
async fn what_a_kill_leaves_is_opened_with_all_its_changes() {
    let (_folder, path) = killed().await;
    let ledger = Ledger::open_checked(&path).await.unwrap();
    assert_eq!(ledger.parts_named("only in the log.stl").await.unwrap().len(), 1);
}

#[tokio::test]
async fn a_log_that_is_gone_or_cut_or_damaged_after_a_kill_is_noticed() {
    let (_folder, path) = killed().await;
    let log = lost_changes::log_of(&path);
    let whole = fs::read(&log).unwrap();
    let index = fs::read(path.with_file_name("nestd.db-shm")).unwrap();
    let again = |bytes: &[u8]| {
        fs::write(&log, bytes).unwrap();
        fs::write(path.with_file_name("nestd.db-shm"), &index).unwrap();
    };
    for kept in [0, 31, 32, 5000, whole.len() - 4096, whole.len() - 1] {
        again(&whole[..kept]);
        assert!(refusal(&path).await.contains("changes are lost"), "{kept}");
    }
    for at in [2, 17, 30, 40, 60, whole.len() / 2, whole.len() - 1] {
        again(&whole);
        flip(&log, at);
        assert!(refusal(&path).await.contains("changes are lost"), "{at}");
    }
    again(&whole);
    fs::remove_file(&log).unwrap();
    assert!(refusal(&path).await.contains("is gone"));
    again(&whole);
    Ledger::open_checked(&path).await.unwrap();
}

#[tokio::test]
async fn a_damaged_log_is_refused_each_time_and_its_files_stay_as_they_are() {
    let (folder, path) = killed().await;
    let log = lost_changes::log_of(&path);
    flip(&log, 60);
    let files = [&path, &log].map(|file| fs::read(file).unwrap());
    for _ in 0..3 {
        refusal(&path).await;
        assert!(files == [&path, &log].map(|file| fs::read(file).unwrap()));
    }
    assert!(folder.path().join("nestd.db-shm").exists());
}

#[tokio::test]
async fn a_note_that_is_behind_or_torn_or_gone_refuses_nothing() {
    let (_folder, path) = killed().await;
    let note = path.with_file_name("nestd.db-changes");
    let noted = noted_change(&path).unwrap();
    assert_eq!((noted.line < 0, noted_loss(&path)), (fs::read_to_string(&note).unwrap().contains('-'), None));
    let noted = noted.changes;
    // An older nestd noted the number alone.
    for text in [format!("{:020}\n", noted - 1), String::new(), "0000".to_owned(), "no number".to_owned()] {
        fs::write(&note, text).unwrap();
        assert!(!check_files(&path).await.unwrap());
    }
    fs::write(&note, format!("{:020}\n", noted + 1)).unwrap();
    assert!(check_files(&path).await.unwrap_err().is_damage());
    fs::remove_file(&note).unwrap();
    Ledger::open_checked(&path).await.unwrap();
}

#[tokio::test]
async fn a_ledger_put_back_by_hand_after_a_kill_is_not_held_against_the_note_of_the_other() {
    let (backup_folder, backup) = closed().await;
    let (_folder, path) = killed().await;
    for file in ["nestd.db-wal", "nestd.db-shm"] {
        fs::remove_file(path.with_file_name(file)).unwrap();
    }
    fs::copy(&backup, &path).unwrap();
    let ledger = Ledger::open_checked(&path).await.unwrap();
    assert!(!path.with_file_name("nestd.db-changes").exists());
    waiting(&ledger, "after it", 1).await;
    assert!(ledger.close_with_checksum().await.unwrap());
    assert!(!path.with_file_name("nestd.db-changes").exists(), "an orderly stop leaves no note");
    drop(backup_folder);
}

#[tokio::test]
async fn damage_without_a_seal_is_noticed_by_looking_at_every_page() {
    let (_folder, path) = closed().await;
    fs::remove_file(checksum_path(&path)).unwrap();
    let whole = fs::read(&path).unwrap();
    for (what, from, to) in [("header", 0, 100), ("schema", 100, 400), ("a page", 3 * 4096, 3 * 4096 + 200)] {
        let mut bytes = whole.clone();
        bytes[from..to].fill(0x55);
        fs::write(&path, bytes).unwrap();
        let error = Ledger::open_checked(&path).await.expect_err(what);
        assert!(error.is_damage(), "{what}: {error:?}");
    }
    fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    refusal(&path).await;
    fs::write(&path, whole).unwrap();
    Ledger::open_checked(&path).await.unwrap();
}

#[tokio::test]
async fn a_word_that_no_state_machine_knows_is_damage_when_it_is_read() {
    let ledger = fresh().await;
    let part = waiting(&ledger, "a", 1).await;
    let raw = SqlitePool::connect_with(SqliteConnectOptions::new().filename(ledger.file().unwrap())).await.unwrap();
    sqlx::query("UPDATE part SET claimed_at = 'yesterdaz'").execute(&raw).await.unwrap();
    let error = ledger.find_part(part).await.unwrap_err();
    assert!(error.is_damage(), "{error}");
    assert!(error.to_string().contains("nestd restore"));
}
