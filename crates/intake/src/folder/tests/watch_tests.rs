//! Tests with real inotify events on real folders.

use std::{
    sync::mpsc::{Receiver, channel},
    time::Instant,
};

use super::*;

const SOON: Duration = Duration::from_secs(5);
const QUIET: Duration = Duration::from_millis(400);

fn watched(paths: &[&Path]) -> (InboxWatcher, Receiver<()>) {
    let (sender, receiver) = channel();
    let paths = paths.iter().map(|p| p.to_path_buf()).collect();
    let watcher = InboxWatcher::start(paths, move || sender.send(()).unwrap_or(())).unwrap();
    // The first watch itself triggers a scan.
    receiver.recv_timeout(SOON).unwrap();
    drain(&receiver);
    (watcher, receiver)
}

fn drain(receiver: &Receiver<()>) {
    while receiver.recv_timeout(QUIET).is_ok() {}
}

#[test]
fn each_way_to_drop_a_file_wakes() {
    let dir = tempfile::tempdir().unwrap();
    let inbox = dir.path().join("inbox");
    fs::create_dir_all(inbox.join("order")).unwrap();
    let (_watcher, woken) = watched(&[&inbox]);
    let outside = dir.path().join("a.stl");
    fs::write(&outside, "x").unwrap();
    let copies: [&dyn Fn() -> io::Result<()>; 4] = [
        &|| fs::copy(&outside, inbox.join("copied.stl")).map(drop),
        &|| fs::hard_link(&outside, inbox.join("linked.stl")),
        &|| fs::rename(&outside, inbox.join("order/moved.stl")),
        &|| fs::create_dir(inbox.join("new")).and_then(|()| fs::write(inbox.join("new/a.stl"), "x")),
    ];
    for (i, copy) in copies.iter().enumerate() {
        copy().unwrap();
        woken.recv_timeout(SOON).unwrap_or_else(|_| panic!("way {i} did not wake"));
        drain(&woken);
    }
}

#[test]
fn reading_and_what_nestd_writes_itself_do_not_wake() {
    let dir = tempfile::tempdir().unwrap();
    let inbox = dir.path().join("inbox");
    fs::create_dir_all(inbox.join(".claimed/x")).unwrap();
    fs::write(inbox.join("a.stl"), "x").unwrap();
    let (_watcher, woken) = watched(&[&inbox]);
    fs::read(inbox.join("a.stl")).unwrap();
    fs::read_dir(&inbox).unwrap().for_each(drop);
    crate::write_status(&inbox, "0 parts", "{}").unwrap();
    fs::write(inbox.join(".claimed/x/a.stl"), "x").unwrap();
    assert!(woken.recv_timeout(QUIET).is_err());
}

#[test]
fn a_file_in_a_folder_that_was_made_later_wakes_and_claims_are_not_watched() {
    let dir = tempfile::tempdir().unwrap();
    let inbox = dir.path().join("inbox");
    fs::create_dir(&inbox).unwrap();
    fs::create_dir_all(dir.path().join("order/sub")).unwrap();
    let (watcher, woken) = watched(&[&inbox]);
    fs::create_dir_all(inbox.join("made/deep/er")).unwrap();
    fs::create_dir_all(inbox.join(".claimed/x/y")).unwrap();
    fs::rename(dir.path().join("order"), inbox.join("moved")).unwrap();
    woken.recv_timeout(SOON).unwrap();
    drain(&woken);
    for folder in ["made/deep/er", "moved/sub"] {
        fs::write(inbox.join(folder).join("a.stl"), "x").unwrap();
        woken.recv_timeout(SOON).unwrap_or_else(|_| panic!("{folder} is not watched"));
        drain(&woken);
    }
    let watched = lock_mutex(&watcher.folders).watched.clone();
    assert!(!watched.iter().any(|folder| folder.starts_with(inbox.join(".claimed"))), "{watched:?}");
}

#[test]
fn folders_that_come_in_a_stream_hold_nobody_up() {
    let dir = tempfile::tempdir().unwrap();
    let (mut watcher, woken) = watched(&[dir.path()]);
    for n in 0..3000 {
        fs::create_dir(dir.path().join(n.to_string())).unwrap();
    }
    let (sender, checked) = channel();
    thread::spawn(move || sender.send(watcher.check_roots()).unwrap());
    assert_eq!(checked.recv_timeout(SOON).unwrap(), [], "nobody waits for ever");
    drain(&woken);
}

#[test]
fn a_watcher_that_is_dropped_wakes_nobody_any_more() {
    let dir = tempfile::tempdir().unwrap();
    let (watcher, woken) = watched(&[dir.path()]);
    drop(watcher);
    fs::write(dir.path().join("a.stl"), "x").unwrap();
    assert_eq!(woken.recv_timeout(SOON), Err(std::sync::mpsc::RecvTimeoutError::Disconnected));
}

#[test]
fn many_events_are_few_wake_ups() {
    let dir = tempfile::tempdir().unwrap();
    let (_watcher, woken) = watched(&[dir.path()]);
    let begun = Instant::now();
    for i in 0..2000 {
        fs::write(dir.path().join(format!("{i}.stl")), "x").unwrap();
    }
    let mut count = 0;
    while woken.recv_timeout(QUIET).is_ok() {
        count += 1;
    }
    let most = 2 + begun.elapsed().as_millis() / MIN_GAP.as_millis();
    assert!((1..=most).contains(&count) && most < 200, "{count} of at most {most}");
}

#[test]
fn a_hot_folder_that_is_made_anew_is_watched_again() {
    let dir = tempfile::tempdir().unwrap();
    let inbox = dir.path().join("inbox");
    fs::create_dir(&inbox).unwrap();
    let (mut watcher, woken) = watched(&[&inbox]);
    fs::remove_dir(&inbox).unwrap();
    assert_eq!(watcher.check_roots().len(), 1);
    fs::create_dir(&inbox).unwrap();
    drain(&woken);
    assert!(watcher.check_roots().is_empty());
    woken.recv_timeout(SOON).unwrap();
    drain(&woken);
    fs::write(inbox.join("a.stl"), "x").unwrap();
    woken.recv_timeout(SOON).unwrap();
}

#[test]
fn a_hot_folder_that_is_not_there_yet_is_no_error() {
    let dir = tempfile::tempdir().unwrap();
    let inbox = dir.path().join("inbox");
    let (sender, woken) = channel();
    let mut watcher = InboxWatcher::start(vec![inbox.clone()], move || sender.send(()).unwrap_or(())).unwrap();
    assert!(woken.recv_timeout(QUIET).is_err());
    fs::create_dir(&inbox).unwrap();
    assert!(watcher.check_roots().is_empty());
    woken.recv_timeout(SOON).unwrap();
}

#[test]
fn lost_events_and_errors_are_a_reason_to_look() {
    let lost = Event::new(EventKind::Other).set_flag(notify::event::Flag::Rescan);
    assert!(is_relevant(&Ok(lost), &[]));
    assert!(is_relevant(&Err(notify::Error::generic("no more")), &[]));
}
