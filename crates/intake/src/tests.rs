//! Tests of the hot folder as people use it: real copies, real clocks, real events.

use std::{
    fs::{self, OpenOptions},
    io::{self, Write},
    path::{Path, PathBuf},
    sync::mpsc::{RecvTimeoutError, channel},
    thread::sleep,
    time::{Duration, Instant, SystemTime},
};

use super::{test_inbox::TestInbox, *};

const RULES: SettleRules = SettleRules { settle_secs: 0.25, unfinished_secs: 30.0, orphan_secs: 30.0 };
const LIMIT: Duration = Duration::from_secs(10);

/// A binary STL with this number of triangles and varying bytes.
fn stl(triangles: u32) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(triangles.to_le_bytes());
    bytes.extend((0..triangles * 50).map(|i| (i % 251) as u8 + 1));
    bytes
}

/// The size of a complete binary STL: 84 + 50 n bytes.
fn has_end(path: &Path, _name: &str) -> io::Result<bool> {
    let bytes = fs::read(path)?;
    let Some(count) = bytes.get(80..84) else { return Ok(false) };
    Ok(bytes.len() == 84 + 50 * u32::from_le_bytes(count.try_into().unwrap()) as usize)
}

/// Serves the hot folder like the daemon until `count` parts are in the store, and for some time afterwards, in case
/// too many parts appear. Returns their names and bytes.
fn serve(farm: &TestInbox, count: usize) -> Vec<(String, Vec<u8>)> {
    let mut inbox = InboxFolder::new(&farm.inbox, ScanLimits::default());
    let mut settler = SettleTracker::new(RULES);
    let store = ContentStore::open(farm.dir.path().join("store")).unwrap();
    let (begun, mut taken, mut done) = (Instant::now(), Vec::new(), None);
    while done.is_none_or(|at: Instant| at.elapsed().as_secs_f64() < 2.0 * RULES.settle_secs) {
        assert!(begun.elapsed() < LIMIT, "only {} of {count} parts were taken", taken.len());
        let seen = inbox.scan().unwrap().entries;
        for ready in settler.observe_scan(&seen, begun.elapsed().as_secs_f64(), has_end) {
            let claim = claim_part(&farm.inbox, &ready).unwrap();
            let stored = store.store_file(&claim.part).unwrap();
            assert_eq!(release_claim(&claim, "").unwrap(), ReleaseOutcome::Removed);
            taken.push((claim.display_name(), fs::read(store.file_path(&stored.hash).unwrap()).unwrap()));
        }
        if taken.len() >= count {
            done = done.or(Some(Instant::now()));
        }
        sleep(Duration::from_millis(20));
    }
    taken
}

/// Writes a file in this number of pieces with a pause after each.
fn write_slowly(path: &Path, bytes: &[u8], pieces: usize, pause: Duration) {
    let mut file = OpenOptions::new().write(true).create(true).truncate(false).open(path).unwrap();
    for piece in bytes.chunks(bytes.len().div_ceil(pieces)) {
        file.write_all(piece).unwrap();
        sleep(pause);
    }
}

#[test]
fn a_file_still_growing_is_not_claimed() {
    let farm = TestInbox::new();
    let part = stl(1000);
    let taken = std::thread::scope(|scope| {
        scope.spawn(|| write_slowly(&farm.inbox.join("a.stl"), &part, 12, Duration::from_millis(80)));
        serve(&farm, 1)
    });
    assert_eq!(taken, [("a.stl".to_owned(), part.clone())]);
}

#[test]
fn a_copy_that_pauses_longer_than_the_settle_time_is_taken_once_whole() {
    let farm = TestInbox::new();
    let part = stl(100);
    let taken = std::thread::scope(|scope| {
        scope.spawn(|| write_slowly(&farm.inbox.join("a.stl"), &part, 4, Duration::from_millis(600)));
        serve(&farm, 1)
    });
    assert_eq!(taken, [("a.stl".to_owned(), part.clone())]);
}

#[test]
fn a_copy_that_allocates_its_whole_size_at_once_is_taken_when_it_is_written() {
    let farm = TestInbox::new();
    let part = stl(4000);
    let path = farm.inbox.join("a.stl");
    let taken = std::thread::scope(|scope| {
        scope.spawn(|| {
            fs::File::create(&path).unwrap().set_len(part.len() as u64).unwrap();
            write_slowly(&path, &part, 12, Duration::from_millis(80));
            // Copying programs finally set the copy's time to that of the original.
            let old = SystemTime::UNIX_EPOCH + Duration::from_secs(1_000_000_000);
            OpenOptions::new().append(true).open(&path).unwrap().set_modified(old).unwrap();
        });
        serve(&farm, 1)
    });
    assert_eq!(taken, [("a.stl".to_owned(), part.clone())]);
}

#[test]
fn files_come_by_rename_by_link_with_old_times_and_in_orders() {
    let farm = TestInbox::new();
    let outside = |name: &str, triangles| -> PathBuf {
        let path = farm.dir.path().join(name);
        fs::write(&path, stl(triangles)).unwrap();
        path
    };
    fs::create_dir_all(farm.inbox.join("k1/k2")).unwrap();
    fs::rename(outside("moved", 1), farm.inbox.join("a moved.stl")).unwrap();
    fs::hard_link(outside("linked", 2), farm.inbox.join("b linked.stl")).unwrap();
    let old = farm.drop_file("k1/k2/c old.stl", "");
    fs::write(&old, stl(3)).unwrap();
    let long_ago = SystemTime::UNIX_EPOCH + Duration::from_secs(1);
    OpenOptions::new().append(true).open(&old).unwrap().set_modified(long_ago).unwrap();
    let expected: Vec<_> = [("a moved.stl", 1), ("b linked.stl", 2), ("c old.stl", 3)]
        .map(|(name, triangles)| (name.to_owned(), stl(triangles)))
        .into();
    assert_eq!(serve(&farm, 3), expected);
    assert_eq!(fs::read(farm.dir.path().join("linked")).unwrap(), stl(2));
}

#[test]
fn the_same_name_dropped_again_is_taken_again() {
    let farm = TestInbox::new();
    for triangles in [1, 2, 2] {
        fs::write(farm.inbox.join("a.stl"), stl(triangles)).unwrap();
        assert_eq!(serve(&farm, 1), [("a.stl".to_owned(), stl(triangles))]);
    }
}

#[test]
fn an_event_brings_a_part_in_long_before_the_next_periodic_scan() {
    let farm = TestInbox::new();
    let (sender, woken) = channel();
    let _watcher = InboxWatcher::start(vec![farm.inbox.clone()], move || sender.send(()).unwrap_or(())).unwrap();
    let (mut settler, begun) = (SettleTracker::new(RULES), Instant::now());
    let mut dropped = false;
    loop {
        let now = begun.elapsed().as_secs_f64();
        let seen = scan_inbox(&farm.inbox, ScanLimits::default()).unwrap().entries;
        if let [SettledEntry::Part { .. }] = settler.observe_scan(&seen, now, has_end)[..] {
            break;
        }
        if !dropped {
            farm.drop_file("a.stl", "");
            fs::write(farm.inbox.join("a.stl"), stl(1)).unwrap();
            dropped = true;
        }
        // The next periodic scan would be in an hour.
        let wait = settler.next_scan_secs(now).unwrap_or(3600.0);
        if woken.recv_timeout(Duration::from_secs_f64(wait)) == Err(RecvTimeoutError::Disconnected) {
            panic!("the watch died");
        }
        assert!(begun.elapsed() < LIMIT);
    }
    assert!(begun.elapsed() < Duration::from_secs(5), "{:?}", begun.elapsed());
}
