//! Tests of the scan with real folders and files of all kinds.

use std::{
    ffi::OsString,
    os::unix::{
        ffi::OsStringExt,
        fs::{PermissionsExt, symlink},
        net::UnixListener,
    },
};

use super::*;

fn names(listing: &InboxListing, inbox: &Path) -> Vec<String> {
    listing.entries.iter().map(|s| s.path.strip_prefix(inbox).unwrap().to_string_lossy().into_owned()).collect()
}

#[test]
fn files_of_the_hot_folder_and_its_orders_are_listed_and_the_rest_is_ignored() {
    let inbox = tempfile::tempdir().unwrap();
    let at = |name: &str| inbox.path().join(name);
    fs::create_dir_all(at("order 7/lid")).unwrap();
    fs::create_dir_all(at("@eaDir")).unwrap();
    fs::create_dir_all(at(".claimed/x")).unwrap();
    for name in ["a.stl", "order 7/b.3mf", "order 7/lid/c.stl", "order 7/STATUS.txt"] {
        fs::write(at(name), "x").unwrap();
    }
    for name in ["STATUS.txt", "status.json", ".hidden.stl", "a.stl.part", "@eaDir/a.stl", ".claimed/x/a.stl"] {
        fs::write(at(name), "x").unwrap();
    }
    let listing = scan_inbox(inbox.path(), ScanLimits::default()).unwrap();
    assert_eq!(names(&listing, inbox.path()), ["a.stl", "order 7/STATUS.txt", "order 7/b.3mf", "order 7/lid/c.stl"]);
    let orders: Vec<_> = listing.entries.iter().map(|s| s.order.as_str()).collect();
    assert_eq!(orders, ["", "order 7", "order 7", "order 7/lid"]);
    assert!(listing.entries.iter().all(|s| s.kind == EntryKind::File && s.size == 1 && s.inode > 0));
    assert!(listing.warnings.is_empty());
}

#[test]
fn the_status_in_a_moved_hot_folder_of_another_machine_is_no_part_of_an_order() {
    let inbox = tempfile::tempdir().unwrap();
    fs::create_dir(inbox.path().join("old")).unwrap();
    for name in ["old/a.stl", "old/.nestd-owner", "old/STATUS.txt", "old/status.json"] {
        fs::write(inbox.path().join(name), "x").unwrap();
    }
    assert_eq!(names(&scan_inbox(inbox.path(), ScanLimits::default()).unwrap(), inbox.path()), ["old/a.stl"]);
}

#[test]
fn names_of_all_kinds_are_listed() {
    let inbox = tempfile::tempdir().unwrap();
    let mut names = vec![
        OsString::from("mit Leerzeichen.stl"),
        OsString::from("größe.stl"),
        OsString::from("部品 🔩.stl"),
        OsString::from("two\nlines.stl"),
        OsString::from_vec(b"latin\xfc.stl".to_vec()),
        OsString::from("n".repeat(251) + ".stl"),
    ];
    for name in &names {
        fs::write(inbox.path().join(name), "x").unwrap();
    }
    names.sort();
    let listing = scan_inbox(inbox.path(), ScanLimits::default()).unwrap();
    let found: Vec<_> = listing.entries.iter().map(|s| s.path.file_name().unwrap().to_owned()).collect();
    assert_eq!(found, names);
}

#[test]
fn what_is_no_file_is_told_by_its_kind_and_no_link_is_followed() {
    let inbox = tempfile::tempdir().unwrap();
    let elsewhere = tempfile::tempdir().unwrap();
    fs::write(elsewhere.path().join("secret.stl"), "x").unwrap();
    let at = |name: &str| inbox.path().join(name);
    symlink(elsewhere.path(), at("a_link")).unwrap();
    symlink("nowhere", at("b_dangling.stl")).unwrap();
    rustix::fs::mknodat(rustix::fs::CWD, at("c_pipe"), rustix::fs::FileType::Fifo, 0o600.into(), 0).unwrap();
    let _socket = UnixListener::bind(at("d_socket")).unwrap();
    fs::create_dir(at("e_folder.STL")).unwrap();
    fs::write(at("e_folder.STL/inner.stl"), "x").unwrap();
    let listing = scan_inbox(inbox.path(), ScanLimits::default()).unwrap();
    let kinds: Vec<_> = listing.entries.iter().map(|s| s.kind).collect();
    assert_eq!(
        kinds,
        [EntryKind::Symlink, EntryKind::Symlink, EntryKind::Fifo, EntryKind::Socket, EntryKind::Directory]
    );
}

#[test]
fn folders_deeper_than_the_limit_are_listed_as_folders() {
    let inbox = tempfile::tempdir().unwrap();
    fs::create_dir_all(inbox.path().join("1/2/3")).unwrap();
    fs::write(inbox.path().join("1/2/a.stl"), "x").unwrap();
    let listing = scan_inbox(inbox.path(), ScanLimits { max_depth: 2, ..Default::default() }).unwrap();
    assert_eq!(names(&listing, inbox.path()), ["1/2/3", "1/2/a.stl"]);
    assert_eq!(listing.entries[0].kind, EntryKind::Directory);
}

#[test]
fn a_hot_folder_that_is_gone_is_unavailable_not_empty() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("inbox");
    fs::create_dir(&path).unwrap();
    let mut inbox = InboxFolder::new(&path, ScanLimits::default());
    assert!(inbox.scan().unwrap().entries.is_empty());
    fs::remove_dir(&path).unwrap();
    assert!(inbox.scan().unwrap_err().to_string().contains("unavailable: it is not there"));
    fs::write(&path, "a file").unwrap();
    assert!(inbox.scan().unwrap_err().to_string().contains("not a folder"));
}

#[test]
#[cfg_attr(no_second_file_system, ignore = "needs /dev/shm as a file system of its own")]
fn another_file_system_in_its_place_is_unavailable_until_the_first_is_back() {
    let disk = tempfile::tempdir().unwrap();
    let memory = tempfile::tempdir_in("/dev/shm").unwrap();
    assert_ne!(fs::metadata(disk.path()).unwrap().dev(), fs::metadata(memory.path()).unwrap().dev());
    let link = disk.path().join("inbox");
    let real = disk.path().join("real");
    fs::create_dir(&real).unwrap();
    symlink(&real, &link).unwrap();
    let mut inbox = InboxFolder::new(&link, ScanLimits::default());
    inbox.scan().unwrap();
    fs::remove_file(&link).unwrap();
    symlink(memory.path(), &link).unwrap();
    assert!(inbox.scan().unwrap_err().to_string().contains("another file system"));
    fs::remove_file(&link).unwrap();
    symlink(&real, &link).unwrap();
    inbox.scan().unwrap();
}

#[test]
fn an_order_that_may_not_be_read_does_not_hide_the_others() {
    let inbox = tempfile::tempdir().unwrap();
    let locked = inbox.path().join("locked");
    fs::create_dir(&locked).unwrap();
    fs::write(inbox.path().join("a.stl"), "x").unwrap();
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o000)).unwrap();
    let readable_anyway = fs::read_dir(&locked).is_ok();
    let listing = scan_inbox(inbox.path(), ScanLimits::default()).unwrap();
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o700)).unwrap();
    assert_eq!(names(&listing, inbox.path()), ["a.stl"]);
    // The superuser reads everything.
    assert!(readable_anyway || listing.warnings[0].1.contains("permission denied"));
}

#[test]
fn more_files_than_the_limit_are_said_not_dropped_silently() {
    let inbox = tempfile::tempdir().unwrap();
    for i in 0..5 {
        fs::write(inbox.path().join(format!("{i}.stl")), "x").unwrap();
    }
    let listing = scan_inbox(inbox.path(), ScanLimits { max_entries: 3, ..Default::default() }).unwrap();
    assert_eq!(listing.entries.len(), 3);
    assert!(listing.warnings[0].1.contains("more than 3"));
}
