//! Tests of refusals on real folders, interrupted after every step, on one file system and across two.

use std::{
    os::unix::{fs::PermissionsExt, net::UnixListener},
    path::PathBuf,
};

use super::*;
use crate::{
    SettledEntry, recover_claims,
    test_inbox::{TestInbox, files, stops_at},
};

fn dropped() -> TestInbox {
    let farm = TestInbox::new();
    farm.drop_file("kit 1/a.stl", "solid");
    farm.drop_file("kit 1/a.stl.toml", "copies = 0");
    farm
}

const REFUSED: [&str; 3] = ["kit 1/a.stl", "kit 1/a.stl.reason.txt", "kit 1/a.stl.toml"];

/// An error folder on another file system than the temporary folder.
fn elsewhere(farm: &TestInbox) -> tempfile::TempDir {
    let memory = tempfile::tempdir_in("/dev/shm").unwrap();
    let dev = |path: &Path| fs::metadata(path).unwrap().dev();
    assert_ne!(dev(memory.path()), dev(&farm.inbox));
    memory
}

#[test]
fn a_refused_part_stands_beside_its_reason_and_its_ticket() {
    let farm = dropped();
    let claim = farm.claim();
    let to = refuse_claim(&claim, &farm.error, "It has no triangles. Export it again.").unwrap();
    assert_eq!(to, farm.error.join("kit 1/a.stl"));
    assert_eq!(files(&farm.error), REFUSED);
    let reason = fs::read_to_string(farm.error.join(REFUSED[1])).unwrap();
    assert!(
        reason.starts_with("a.stl was refused.\n\nIt has no triangles. Export it again.\n\nFile: kit 1/a.stl\n"),
        "{reason}"
    );
    assert!(farm.claimed().is_empty() && recover_claims(&farm.inbox, "").unwrap().0.is_empty());
}

#[test]
fn nothing_in_the_error_folder_is_overwritten() {
    let farm = dropped();
    for _ in 0..3 {
        farm.drop_file("kit 1/a.stl", "solid");
        farm.drop_file("kit 1/a.stl.toml", "copies = 0");
        refuse_claim(&farm.claim(), &farm.error, "No.").unwrap();
    }
    let names = files(&farm.error);
    assert_eq!(names.len(), 9, "{names:?}");
    for name in ["kit 1/a (3).stl", "kit 1/a (3).stl.reason.txt", "kit 1/a (3).stl.toml"] {
        assert!(names.contains(&name.to_owned()), "{names:?}");
    }
}

#[test]
fn a_refusal_stopped_anywhere_is_finished_by_the_next_one() {
    for stop in 1.. {
        let farm = dropped();
        let claim = farm.claim();
        if !stops_at(stop, |step| refuse_stepwise(&claim, &farm.error, "No.", step)) {
            assert!(stop > 6);
            return;
        }
        let left = recover_claims(&farm.inbox, "").unwrap().0;
        let parts = files(&farm.error).iter().filter(|f| f.ends_with("a.stl")).count();
        assert_eq!(left.len() + parts, 1, "stop {stop}");
        for claim in &left {
            assert_eq!(claim.tickets.len(), 1, "stop {stop}: the part lost its ticket");
            refuse_claim(claim, &farm.error, "No.").unwrap();
        }
        assert_eq!(files(&farm.error)[..2], REFUSED[..2], "stop {stop}");
        // A ticket whose part was already moved is given back, and is later refused as an orphan.
        assert_eq!(files(&farm.error).len() + farm.dropped().len(), 3, "stop {stop}");
        assert!(farm.claimed().is_empty());
    }
}

#[test]
#[cfg_attr(no_second_file_system, ignore = "needs /dev/shm as a file system of its own")]
fn a_refusal_goes_across_file_systems() {
    let farm = dropped();
    let memory = elsewhere(&farm);
    refuse_claim(&farm.claim(), memory.path(), "No.").unwrap();
    assert_eq!(files(memory.path()), REFUSED);
    assert_eq!(fs::read_to_string(memory.path().join(REFUSED[0])).unwrap(), "solid");
    assert!(farm.claimed().is_empty());
}

#[test]
#[cfg_attr(no_second_file_system, ignore = "needs /dev/shm as a file system of its own")]
fn a_refusal_across_file_systems_that_stopped_after_the_copy_leaves_one() {
    let farm = dropped();
    let memory = elsewhere(&farm);
    let claim = farm.claim();
    assert!(stops_at(2, |step| refuse_stepwise(&claim, memory.path(), "No.", step)));
    assert_eq!(files(memory.path()), REFUSED[1..2]);
    fs::copy(&claim.part, memory.path().join(REFUSED[0])).unwrap();
    refuse_claim(&recover_claims(&farm.inbox, "").unwrap().0[0], memory.path(), "No.").unwrap();
    assert_eq!(files(memory.path()), REFUSED);
    assert!(farm.claimed().is_empty());
}

#[test]
fn a_stranger_under_the_same_name_is_not_mistaken_for_a_copy() {
    let farm = dropped();
    let claim = farm.claim();
    assert!(stops_at(2, |step| refuse_stepwise(&claim, &farm.error, "No.", step)));
    fs::write(farm.error.join(REFUSED[0]), "other").unwrap();
    let to = refuse_claim(&claim, &farm.error, "No.").unwrap();
    assert_eq!(to, farm.error.join("kit 1/a (2).stl"));
    assert_eq!(fs::read_to_string(farm.error.join(REFUSED[0])).unwrap(), "other");
}

#[test]
fn names_of_255_bytes_get_a_reason_too() {
    let farm = TestInbox::new();
    let names = ["n".repeat(251) + ".stl", "n".repeat(250) + "m.stl", "ü".repeat(127)];
    for name in &names {
        farm.drop_file(name, "solid");
        refuse_claim(&farm.claim(), &farm.error, "No.").unwrap();
    }
    let found = files(&farm.error);
    assert_eq!(found.len(), 6, "{found:?}");
    assert!(names.iter().all(|n| found.contains(n) || found.iter().any(|f| f.ends_with(" (2).stl"))), "{found:?}");
    assert_eq!(found.iter().filter(|f| f.ends_with(".reason.txt")).count(), 3);
}

#[test]
fn an_error_folder_that_cannot_be_written_leaves_the_claim_whole() {
    let farm = dropped();
    let claim = farm.claim();
    fs::write(&farm.error, "a file in its place").unwrap();
    assert!(refuse_claim(&claim, &farm.error, "No.").is_err());
    fs::remove_file(&farm.error).unwrap();
    fs::create_dir(&farm.error).unwrap();
    fs::set_permissions(&farm.error, fs::Permissions::from_mode(0o500)).unwrap();
    let result = refuse_claim(&claim, &farm.error, "No.");
    fs::set_permissions(&farm.error, fs::Permissions::from_mode(0o700)).unwrap();
    // The superuser may write in any case.
    if let Err(error) = result {
        assert!(error.to_string().contains("cannot create"), "{error}");
        assert_eq!(recover_claims(&farm.inbox, "").unwrap().0, [claim]);
    }
}

fn refuse_all(farm: &TestInbox, error_dir: &Path) -> Vec<PathBuf> {
    let refused = farm.ready().into_iter().filter_map(|ready| match ready {
        SettledEntry::Refuse { seen, reason }
        | SettledEntry::Orphan { ticket: seen, expiry_reason: Some(reason), .. } => {
            Some(refuse_entry(&farm.inbox, &seen, error_dir, &reason).unwrap())
        }
        _ => None,
    });
    refused.collect()
}

fn drop_oddities(farm: &TestInbox) -> UnixListener {
    let at = |name: &str| farm.inbox.join(name);
    fs::create_dir_all(at("k/folder.stl/inner")).unwrap();
    fs::write(at("k/folder.stl/inner/b.stl"), "x").unwrap();
    std::os::unix::fs::symlink("/etc/hostname", at("k/link.stl")).unwrap();
    rustix::fs::mknodat(rustix::fs::CWD, at("k/pipe.stl"), rustix::fs::FileType::Fifo, 0o600.into(), 0).unwrap();
    farm.drop_file("k/gone.stl.toml", "copies = 2");
    UnixListener::bind(at("k/socket")).unwrap()
}

#[test]
fn what_is_no_part_is_moved_to_the_error_folder_as_it_is() {
    let farm = TestInbox::new();
    let _socket = drop_oddities(&farm);
    assert_eq!(refuse_all(&farm, &farm.error).len(), 5);
    assert!(farm.dropped().is_empty());
    let kind = |name: &str| fs::symlink_metadata(farm.error.join("k").join(name)).unwrap().file_type();
    assert!(kind("link.stl").is_symlink() && kind("folder.stl").is_dir());
    use std::os::unix::fs::FileTypeExt;
    assert!(kind("pipe.stl").is_fifo() && kind("socket").is_socket());
    assert!(farm.error.join("k/folder.stl/inner/b.stl").exists());
    let reason = fs::read_to_string(farm.error.join("k/gone.stl.toml.reason.txt")).unwrap();
    assert!(reason.contains("no such part came"), "{reason}");
}

#[test]
#[cfg_attr(no_second_file_system, ignore = "needs /dev/shm as a file system of its own")]
fn what_is_no_part_is_moved_across_file_systems_too() {
    let farm = TestInbox::new();
    let memory = elsewhere(&farm);
    let _socket = drop_oddities(&farm);
    assert_eq!(refuse_all(&farm, memory.path()).len(), 5);
    assert!(farm.dropped().is_empty());
    let at = |name: &str| memory.path().join("k").join(name);
    assert_eq!(fs::read_link(at("link.stl")).unwrap(), PathBuf::from("/etc/hostname"));
    assert_eq!(fs::read_to_string(at("folder.stl/inner/b.stl")).unwrap(), "x");
    assert!(at("pipe.stl.reason.txt").exists() && at("socket.reason.txt").exists());
}

#[test]
fn what_was_replaced_since_it_was_seen_is_not_refused_in_its_stead() {
    let farm = TestInbox::new();
    std::os::unix::fs::symlink("/etc/hostname", farm.inbox.join("a.stl")).unwrap();
    let [SettledEntry::Refuse { seen, .. }] = &farm.ready()[..] else { panic!("no link is ready") };
    fs::rename(farm.inbox.join("a.stl"), farm.dir.path().join("kept")).unwrap();
    farm.drop_file("a.stl", "solid");
    assert!(refuse_entry(&farm.inbox, seen, &farm.error, "No.").is_err());
    assert_eq!(farm.dropped(), ["a.stl"]);
}

#[test]
fn a_refusal_that_was_done_is_found_done_by_the_next_try() {
    let farm = TestInbox::new();
    farm.drop_file("a.stl", "solid");
    let error_dir = farm.dir.path().join("error");
    let claim = farm.claim();
    let first = refuse_claim(&claim, &error_dir, "No.").unwrap();
    // The first attempt may have failed after it moved the part.
    assert_eq!(refuse_claim(&claim, &error_dir, "No.").unwrap(), first);
    assert_eq!(fs::read_dir(&error_dir).unwrap().count(), 2);
    fs::remove_file(&first).unwrap();
    assert_eq!(refuse_claim(&claim, &error_dir, "No.").unwrap(), first);
    fs::remove_file(error_dir.join("a.stl.reason.txt")).unwrap();
    assert!(refuse_claim(&claim, &error_dir, "No.").is_err());
}
