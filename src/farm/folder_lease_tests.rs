//! Leases on folders: one daemon at a time, and never on an empty directory in the place of a folder.

use super::{super::folder_check, *};

fn holder(host: &str, state_dir: &Path) -> LeaseHolder {
    LeaseHolder { host: host.to_owned(), ..LeaseHolder::for_this_process(state_dir, Timestamp::UNIX_EPOCH).unwrap() }
}

#[test]
fn a_folder_has_one_owner_at_a_time_and_the_refusal_names_it() {
    let dir = tempfile::tempdir().unwrap();
    let (a, b, folder) = (dir.path().join("a"), dir.path().join("b"), dir.path().join("inbox"));
    for made in [&a, &b, &folder] {
        fs::create_dir(made).unwrap();
    }
    let lock = state_lock::StateDirLock::acquire(&a, Timestamp::UNIX_EPOCH).unwrap();
    let mut first = FolderLease::new(holder(&state_lock::host_name(), &a), &folder);
    first.renew().unwrap();
    first.renew().unwrap();
    let mut second = FolderLease::new(holder(&state_lock::host_name(), &b), &folder);
    let refused = second.renew().unwrap_err().to_string();
    let pid = std::process::id();
    assert!(refused.contains(&format!("process {pid} on {}", state_lock::host_name())), "{refused}");
    assert!(refused.contains("since 1970-01-01") && refused.contains("Stop that one"), "{refused}");
    drop(lock);
    second.renew().unwrap();
    assert!(fs::metadata(folder.join(NAME)).unwrap().len() == BYTES as u64);
}

#[test]
fn a_daemon_on_another_server_lives_while_its_number_moves() {
    let dir = tempfile::tempdir().unwrap();
    let mut far = FolderLease::new(holder("far", dir.path()), dir.path());
    let mut near = FolderLease::new(holder("near", dir.path()), dir.path());
    far.renew().unwrap();
    assert!(matches!(near.renew(), Err(LeaseError::HolderUnclear { .. })));
    assert!(matches!(near.renew(), Err(LeaseError::HolderUnclear { .. })));
    far.renew().unwrap();
    assert!(matches!(near.renew(), Err(LeaseError::HeldByOther { .. })));
    far.release();
    near.renew().unwrap();
    assert!(matches!(far.renew(), Err(LeaseError::HolderUnclear { .. })));
}

#[test]
fn an_empty_directory_in_its_place_is_not_the_folder_and_a_lost_marker_is_made_again() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("inbox");
    fs::create_dir(&folder).unwrap();
    let mut lease = FolderLease::new(holder("here", dir.path()), &folder);
    lease.renew().unwrap();
    fs::remove_file(folder.join(NAME)).unwrap();
    lease.renew().unwrap();
    fs::rename(&folder, dir.path().join("away")).unwrap();
    assert!(matches!(lease.renew(), Err(LeaseError::Io { .. })));
    fs::create_dir(&folder).unwrap();
    assert!(matches!(lease.renew(), Err(LeaseError::Replaced(_))));
    assert!(!folder.join(NAME).exists());
    fs::remove_dir(&folder).unwrap();
    fs::rename(dir.path().join("away"), &folder).unwrap();
    lease.renew().unwrap();
}

#[test]
fn a_folder_that_was_served_and_lost_its_marker_is_not_new_after_a_restart_until_a_person_accepts_it() {
    let dir = tempfile::tempdir().unwrap();
    let (state, folder) = (dir.path().join("state"), dir.path().join("archive"));
    fs::create_dir(&state).unwrap();
    fs::create_dir(&folder).unwrap();
    let restarted = || FolderLease::new(holder("here", &state), &folder);
    assert!(restarted().was_never_served());
    restarted().renew().unwrap();
    assert!(!restarted().was_never_served());
    // A marker that was deleted is written again: it is the same folder.
    fs::remove_file(folder.join(NAME)).unwrap();
    folder_check::check_readable(&state, &folder).unwrap();
    restarted().renew().unwrap();
    fs::rename(&folder, dir.path().join("away")).unwrap();
    assert!(matches!(folder_check::check_readable(&state, &folder), Err(LeaseError::Io { .. })));
    assert!(!restarted().was_never_served());
    fs::create_dir(&folder).unwrap();
    let refused = restarted().renew().unwrap_err().to_string();
    assert!(refused.contains("Mount it again") && refused.contains("touch "), "{refused}");
    assert!(matches!(folder_check::check_readable(&state, &folder), Err(LeaseError::Replaced(_))));
    assert!(!folder.join(NAME).exists());
    fs::write(folder.join(NAME), "").unwrap();
    folder_check::check_readable(&state, &folder).unwrap();
    restarted().renew().unwrap();
    fs::remove_file(folder.join(NAME)).unwrap();
    restarted().renew().unwrap();
}

#[test]
fn what_lies_in_a_folder_of_another_farm_is_not_read_for_this_one() {
    let dir = tempfile::tempdir().unwrap();
    let (a, b, folder) = (dir.path().join("a"), dir.path().join("b"), dir.path().join("archive"));
    for made in [&a, &b, &folder] {
        fs::create_dir(made).unwrap();
    }
    let mut far = FolderLease::new(holder("far", &a), &folder);
    far.renew().unwrap();
    assert!(matches!(folder_check::check_readable(&b, &folder), Err(LeaseError::HeldByOther { .. })));
    far.release();
    folder_check::check_readable(&b, &folder).unwrap();
    // A lost state folder gets a new farm id: the folders still belong to its farm.
    FolderLease::new(holder(&state_lock::host_name(), &a), &folder).renew().unwrap();
    fs::remove_file(a.join(FARM_ID_FILE)).unwrap();
    folder_check::check_readable(&a, &folder).unwrap();
}

#[test]
fn who_stood_still_after_its_look_does_not_write_over_the_name_of_another() {
    let dir = tempfile::tempdir().unwrap();
    let me = holder("here", dir.path());
    assert!(write_marker(dir.path(), &me, LeaseTimestamp::long_ago()).is_err());
    assert_eq!(read_marker(dir.path()).unwrap(), LeaseMarker::NoHolder);
    write_marker(dir.path(), &me, LeaseTimestamp::now()).unwrap();
    FolderLease::new(me, dir.path()).check_held().unwrap();
    assert!(matches!(
        FolderLease::new(holder("far", dir.path()), dir.path()).check_held(),
        Err(LeaseError::HeldByOther { .. })
    ));
}
