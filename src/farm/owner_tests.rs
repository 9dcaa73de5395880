//! Who serves a folder: one daemon at a time, and never an empty directory in the place of one.

use super::{super::marked, *};

fn owner(host: &str, state_dir: &Path) -> Owner {
    Owner { host: host.to_owned(), ..Owner::of_this_process(state_dir, Timestamp::UNIX_EPOCH).unwrap() }
}

#[test]
fn a_folder_has_one_owner_at_a_time_and_the_refusal_names_it() {
    let dir = tempfile::tempdir().unwrap();
    let (a, b, folder) = (dir.path().join("a"), dir.path().join("b"), dir.path().join("inbox"));
    for made in [&a, &b, &folder] {
        fs::create_dir(made).unwrap();
    }
    let lock = lock::Lock::take(&a, Timestamp::UNIX_EPOCH).unwrap();
    let mut first = Hold::new(owner(&lock::host_name(), &a), &folder);
    first.keep().unwrap();
    first.keep().unwrap();
    let mut second = Hold::new(owner(&lock::host_name(), &b), &folder);
    let refused = second.keep().unwrap_err().to_string();
    let pid = std::process::id();
    assert!(refused.contains(&format!("process {pid} on {}", lock::host_name())), "{refused}");
    assert!(refused.contains("since 1970-01-01") && refused.contains("Stop that one"), "{refused}");
    drop(lock);
    second.keep().unwrap();
    assert!(fs::metadata(folder.join(NAME)).unwrap().len() == BYTES as u64);
}

#[test]
fn a_daemon_on_another_server_lives_while_its_number_moves() {
    let dir = tempfile::tempdir().unwrap();
    let mut far = Hold::new(owner("far", dir.path()), dir.path());
    let mut near = Hold::new(owner("near", dir.path()), dir.path());
    far.keep().unwrap();
    assert!(matches!(near.keep(), Err(OwnerError::Unclear { .. })));
    assert!(matches!(near.keep(), Err(OwnerError::Unclear { .. })));
    far.keep().unwrap();
    assert!(matches!(near.keep(), Err(OwnerError::Other { .. })));
    far.end();
    near.keep().unwrap();
    assert!(matches!(far.keep(), Err(OwnerError::Unclear { .. })));
}

#[test]
fn an_empty_directory_in_its_place_is_not_the_folder_and_a_lost_marker_is_made_again() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("inbox");
    fs::create_dir(&folder).unwrap();
    let mut hold = Hold::new(owner("here", dir.path()), &folder);
    hold.keep().unwrap();
    fs::remove_file(folder.join(NAME)).unwrap();
    hold.keep().unwrap();
    fs::rename(&folder, dir.path().join("away")).unwrap();
    assert!(matches!(hold.keep(), Err(OwnerError::Io { .. })));
    fs::create_dir(&folder).unwrap();
    assert!(matches!(hold.keep(), Err(OwnerError::Replaced(_))));
    assert!(!folder.join(NAME).exists());
    fs::remove_dir(&folder).unwrap();
    fs::rename(dir.path().join("away"), &folder).unwrap();
    hold.keep().unwrap();
}

#[test]
fn a_folder_that_was_served_and_lost_its_marker_is_not_new_after_a_restart_until_a_person_accepts_it() {
    let dir = tempfile::tempdir().unwrap();
    let (state, folder) = (dir.path().join("state"), dir.path().join("archive"));
    fs::create_dir(&state).unwrap();
    fs::create_dir(&folder).unwrap();
    let restarted = || Hold::new(owner("here", &state), &folder);
    assert!(restarted().is_new());
    restarted().keep().unwrap();
    assert!(!restarted().is_new());
    // A marker that was tidied away is made again: it is the same folder.
    fs::remove_file(folder.join(NAME)).unwrap();
    marked::demand_readable(&state, &folder).unwrap();
    restarted().keep().unwrap();
    fs::rename(&folder, dir.path().join("away")).unwrap();
    assert!(matches!(marked::demand_readable(&state, &folder), Err(OwnerError::Io { .. })));
    assert!(!restarted().is_new());
    fs::create_dir(&folder).unwrap();
    let refused = restarted().keep().unwrap_err().to_string();
    assert!(refused.contains("Mount it again") && refused.contains("touch "), "{refused}");
    assert!(matches!(marked::demand_readable(&state, &folder), Err(OwnerError::Replaced(_))));
    assert!(!folder.join(NAME).exists());
    fs::write(folder.join(NAME), "").unwrap();
    marked::demand_readable(&state, &folder).unwrap();
    restarted().keep().unwrap();
    fs::remove_file(folder.join(NAME)).unwrap();
    restarted().keep().unwrap();
}

#[test]
fn what_lies_in_a_folder_of_another_farm_is_not_read_for_this_one() {
    let dir = tempfile::tempdir().unwrap();
    let (a, b, folder) = (dir.path().join("a"), dir.path().join("b"), dir.path().join("archive"));
    for made in [&a, &b, &folder] {
        fs::create_dir(made).unwrap();
    }
    let mut far = Hold::new(owner("far", &a), &folder);
    far.keep().unwrap();
    assert!(matches!(marked::demand_readable(&b, &folder), Err(OwnerError::Other { .. })));
    far.end();
    marked::demand_readable(&b, &folder).unwrap();
    // A state folder that was lost has another number: the folders are still those of its farm.
    Hold::new(owner(&lock::host_name(), &a), &folder).keep().unwrap();
    fs::remove_file(a.join(FARM)).unwrap();
    marked::demand_readable(&a, &folder).unwrap();
}

#[test]
fn who_stood_still_after_its_look_does_not_write_over_the_name_of_another() {
    let dir = tempfile::tempdir().unwrap();
    let me = owner("here", dir.path());
    assert!(write(dir.path(), &me, Stamp::long_ago()).is_err());
    assert_eq!(read(dir.path()).unwrap(), Mark::Blank);
    write(dir.path(), &me, Stamp::now()).unwrap();
    Hold::new(me, dir.path()).demand_mine().unwrap();
    assert!(matches!(Hold::new(owner("far", dir.path()), dir.path()).demand_mine(), Err(OwnerError::Other { .. })));
}
