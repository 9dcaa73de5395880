//! Leases on folders: one daemon at a time, and never on an empty directory in the place of a folder.

use std::fs;

use jiff::Timestamp;

use super::{
    super::{folder_check, lease_holder::FARM_ID_FILE, state_lock},
    lease_marker::{BYTES, NAME},
    *,
};

fn holder(host: &str, state_dir: &Path) -> LeaseHolder {
    let here = LeaseHolder::for_this_process(state_dir, Timestamp::UNIX_EPOCH).unwrap();
    LeaseHolder { host: host.to_owned(), place: format!("{host} {}", here.place), ..here }
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

/// Renews until it is clear that the other daemon is dead.
fn renew_after_takeover_delay(lease: &mut FolderLease) {
    let (_, since) = lease.other_holder.as_mut().unwrap();
    *since -= takeover_delay();
    lease.renew().unwrap();
}

#[test]
fn whoever_served_a_folder_in_between_has_interrupted_the_lease_even_if_it_has_stopped_or_has_the_same_id() {
    let dir = tempfile::tempdir().unwrap();
    let me = holder("here", dir.path());
    let mut lease = FolderLease::new(me.clone(), dir.path());
    lease.renew().unwrap();
    lease.renew().unwrap();
    lease.clone().check_held().unwrap();
    assert_eq!(lease.interruption_count(), 0);
    // A copy of the farm on another server, which has stopped in order meanwhile.
    let mut copy =
        FolderLease::new(LeaseHolder { host: "far".to_owned(), place: "far".to_owned(), ..me.clone() }, dir.path());
    let _ = copy.renew();
    renew_after_takeover_delay(&mut copy);
    assert!(lease.clone().check_held().is_err());
    copy.release();
    assert!(lease.clone().check_held().is_err());
    lease.renew().unwrap();
    assert_eq!(lease.interruption_count(), 1);
    // A copy of the running machine: same name, same folder, same process; only its beat differs.
    let mut twin = FolderLease { written: Arc::default(), ..lease.clone() };
    twin.holder.pid += 1;
    twin.renew().unwrap();
    assert!(matches!(lease.renew(), Err(LeaseError::HolderUnclear { .. })));
    assert!(lease.clone().check_held().is_err());
    twin.renew().unwrap();
    assert!(matches!(lease.renew(), Err(LeaseError::HeldByOther { .. })));
    renew_after_takeover_delay(&mut lease);
    assert!(lease.interruption_count() > 2);
    // Its own marker of before, as after the share was put back to a snapshot.
    let (before, count) = (fs::read(dir.path().join(NAME)).unwrap(), lease.interruption_count());
    for _ in 0..3 {
        lease.renew().unwrap();
    }
    fs::write(dir.path().join(NAME), before).unwrap();
    assert!(lease.clone().check_held().is_err());
    assert!(lease.renew().is_err());
    renew_after_takeover_delay(&mut lease);
    assert!(lease.interruption_count() > count);
    // A marker that was removed says nothing of who was here.
    let count = lease.interruption_count();
    fs::remove_file(dir.path().join(NAME)).unwrap();
    lease.renew().unwrap();
    assert_eq!(lease.interruption_count(), count + 1);
}

#[test]
fn a_copied_machine_of_the_same_name_is_another_daemon_and_a_container_of_another_name_is_not() {
    let dir = tempfile::tempdir().unwrap();
    let (state, folder) = (dir.path().join("state"), dir.path().join("inbox"));
    fs::create_dir(&state).unwrap();
    fs::create_dir(&folder).unwrap();
    let me = LeaseHolder::for_this_process(&state, Timestamp::UNIX_EPOCH).unwrap();
    FolderLease::new(me.clone(), &folder).renew().unwrap();
    let copy = LeaseHolder { place: "another boot".to_owned(), ..me.clone() };
    assert!(matches!(FolderLease::new(copy, &folder).renew(), Err(LeaseError::HolderUnclear { .. })));
    FolderLease::new(LeaseHolder { host: "0f3a".to_owned(), ..me }, &folder).renew().unwrap();
    folder_check::check_readable(&state, &folder).unwrap();
}
