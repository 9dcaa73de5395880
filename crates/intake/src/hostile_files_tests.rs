//! Tests of attacks by somebody who may write into the hot folder: links, pipes and hard links planted where nestd
//! reads, moves or writes.

use std::{
    fs,
    os::unix::fs::{MetadataExt, PermissionsExt, symlink},
    path::{Path, PathBuf},
    sync::mpsc,
    thread,
    time::Duration,
};

use super::{
    test_inbox::{TestInbox, files},
    *,
};

/// Runs `work`, which must not block on a pipe without a writer.
fn in_time<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> T {
    let (done, wait) = mpsc::channel();
    thread::spawn(move || done.send(work()));
    wait.recv_timeout(Duration::from_secs(10)).expect("it must not wait")
}

fn pipe(path: &Path) -> std::io::Result<()> {
    let mode = rustix::fs::Mode::from_raw_mode(0o600);
    Ok(rustix::fs::mknodat(rustix::fs::CWD, path, rustix::fs::FileType::Fifo, mode, 0)?)
}

/// A folder with a file that nestd must not touch.
fn precious(farm: &TestInbox) -> (PathBuf, PathBuf) {
    let folder = farm.dir.path().join("precious");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("a.stl"), "mine").unwrap();
    hide(&folder.join("a.stl"));
    (folder.clone(), folder.join("a.stl"))
}

/// What is decided of the entries of a folder where nothing changes any more.
fn judged(farm: &TestInbox, incomplete_secs: f64) -> Vec<TakeDecision> {
    farm.judged(OrderListRules { incomplete_secs, unlisted: UnlistedPolicy::Refuse })
}

/// Only its owner may read it.
fn hide(file: &Path) {
    fs::set_permissions(file, fs::Permissions::from_mode(0o600)).unwrap();
}

#[test]
fn a_pipe_under_the_name_of_a_reason_does_not_stop_a_refusal() {
    let farm = TestInbox::new();
    farm.drop_file("a.stl", "solid");
    fs::create_dir(&farm.error).unwrap();
    pipe(&farm.error.join("a.stl.reason.txt")).unwrap();
    let (claim, error) = (farm.claim(), farm.error.clone());
    in_time(move || refuse_claim(&claim, &error, "No.").unwrap());
    assert_eq!(files(&farm.error), ["a (2).stl", "a (2).stl.reason.txt", "a.stl.reason.txt"]);
}

#[test]
fn a_link_among_the_claims_is_not_taken_for_one() {
    for name in [".new-1", "20261120T120000000Z-0000-00000000", ".done-1"] {
        let farm = TestInbox::new();
        let (folder, file) = precious(&farm);
        fs::create_dir(farm.inbox.join(".claimed")).unwrap();
        symlink(&folder, farm.inbox.join(".claimed").join(name)).unwrap();
        assert!(recover_claims(&farm.inbox, "").unwrap().0.is_empty());
        assert_eq!(fs::read_to_string(&file).unwrap(), "mine", "{name}");
        assert!(farm.dropped().is_empty(), "{name}: {:?}", farm.dropped());
    }
}

#[test]
fn nothing_is_claimed_through_a_link_in_place_of_the_claims() {
    let farm = TestInbox::new();
    let (folder, file) = precious(&farm);
    fs::create_dir(folder.join(".new-1")).unwrap();
    fs::write(folder.join(".new-1/b.stl"), "mine").unwrap();
    symlink(&folder, farm.inbox.join(".claimed")).unwrap();
    farm.drop_file("c.stl", "solid");
    assert!(claim_part(&farm.inbox, &farm.ready_part()).is_err());
    assert!(recover_claims(&farm.inbox, "").is_err());
    assert_eq!(farm.dropped(), ["c.stl"]);
    assert!(file.exists() && folder.join(".new-1/b.stl").exists());
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 2);
}

#[test]
fn a_mark_of_a_served_row_is_not_written_through_a_link() {
    let farm = TestInbox::new();
    let (_, file) = precious(&farm);
    farm.drop_file("b.stl", "solid");
    let list = fs::metadata(farm.drop_file("order.csv", "file,copies\nb.stl,7\n")).unwrap();
    let ctime_ns = i128::from(list.ctime()) * 1_000_000_000 + i128::from(list.ctime_nsec());
    let marks = farm.inbox.join(format!(".claimed/.lists/{}-{ctime_ns}", list.ino()));
    fs::create_dir_all(&marks).unwrap();
    symlink(&file, marks.join(&blake3::hash(b"b.stl").to_hex()[..32])).unwrap();
    let claim = farm.claim();
    assert_eq!(claim.read_part_spec().unwrap().ticket.copies, Some(7));
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
}

#[test]
fn a_folder_of_a_claim_that_became_a_link_leads_to_no_file() {
    let farm = TestInbox::new();
    let (folder, file) = precious(&farm);
    farm.drop_file("kit/a.stl", "solid");
    let claim = farm.claim();
    fs::rename(claim.dir.join("kit"), claim.dir.join("elsewhere")).unwrap();
    symlink(&folder, claim.dir.join("kit")).unwrap();
    let store = ContentStore::open(farm.dir.path().join("store")).unwrap();
    assert!(store.store_claimed(&claim).is_err());
    assert!(refuse_claim(&claim, &farm.error, "No.").is_err());
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
    assert!(!files(&farm.error).contains(&"kit/a.stl".to_owned()));
}

#[test]
fn an_order_folder_of_the_error_folder_that_became_a_link_takes_nothing() {
    let farm = TestInbox::new();
    let (folder, _) = precious(&farm);
    farm.drop_file("kit/bad.build.3mf", "no package");
    fs::create_dir(&farm.error).unwrap();
    symlink(&folder, farm.error.join("kit")).unwrap();
    let claim = farm.claim();
    assert!(refuse_claim(&claim, &farm.error, "No.").is_err());
    assert_eq!(files(&folder), ["a.stl"]);
    assert!(claim.part.exists(), "it stays claimed until somebody puts the folder right");
}

#[test]
fn a_given_back_part_does_not_go_through_a_link() {
    let farm = TestInbox::new();
    let (folder, _) = precious(&farm);
    farm.drop_file("kit/lid/b.stl", "solid");
    let claim = farm.claim();
    fs::remove_dir_all(farm.inbox.join("kit")).unwrap();
    symlink(&folder, farm.inbox.join("kit")).unwrap();
    assert!(give_back_claim(&claim).is_err());
    assert_eq!(files(&folder), ["a.stl"]);
    assert!(!folder.join("lid").exists(), "not even a folder is made there");
}

#[test]
fn the_end_of_a_file_is_looked_for_in_regular_files_of_the_hot_folder_only() {
    let farm = TestInbox::new();
    let (folder, file) = precious(&farm);
    pipe(&farm.inbox.join("pipe.stl")).unwrap();
    symlink(&file, farm.inbox.join("link.stl")).unwrap();
    symlink(&folder, farm.inbox.join("kit")).unwrap();
    fs::create_dir(farm.inbox.join("folder.stl")).unwrap();
    let inbox = farm.inbox.clone();
    in_time(move || {
        for name in ["pipe.stl", "link.stl", "kit/a.stl", "folder.stl", "../precious/a.stl", "none.stl"] {
            assert!(open_dropped_file(&inbox, &inbox.join(name)).is_err(), "{name}");
        }
        assert!(open_dropped_file(&inbox, Path::new("/etc/hostname")).is_err());
    });
    farm.drop_file("b.stl", "solid");
    assert!(open_dropped_file(&farm.inbox, &farm.inbox.join("b.stl")).is_ok());
}

#[test]
fn a_second_name_of_a_file_that_not_all_may_read_is_refused_unread_and_the_other_name_keeps_it() {
    let farm = TestInbox::new();
    let (_, file) = precious(&farm);
    fs::hard_link(&file, farm.inbox.join("a.stl")).unwrap();
    let ready = farm.ready();
    let [SettledEntry::Refuse { seen, reason }] = &ready[..] else { panic!("{ready:?}") };
    assert!(reason.contains("another name"), "{reason}");
    refuse_entry(&farm.inbox, seen, &farm.error, reason).unwrap();
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
    assert!(farm.dropped().is_empty());
}

#[test]
fn a_second_name_made_while_a_file_is_claimed_sends_it_back() {
    let farm = TestInbox::new();
    let part = farm.drop_file("a.stl", "solid");
    hide(&part);
    let ready = farm.ready_part();
    fs::hard_link(&part, farm.dir.path().join("second")).unwrap();
    assert!(matches!(claim_part(&farm.inbox, &ready), Err(ClaimError::Changed(_))));
    assert_eq!(farm.dropped(), ["a.stl"]);
}

#[test]
fn a_part_whose_ticket_or_list_has_a_second_name_is_refused_as_its_copies_are_not_known() {
    for name in ["a.stl.toml", "order.csv"] {
        let farm = TestInbox::new();
        farm.drop_file("a.stl", "solid");
        fs::write(farm.dir.path().join("secret"), "copies = 3").unwrap();
        hide(&farm.dir.path().join("secret"));
        fs::hard_link(farm.dir.path().join("secret"), farm.inbox.join(name)).unwrap();
        let (waiting, over) = (judged(&farm, 1000.0), judged(&farm, 0.0));
        assert!(waiting.iter().all(|one| matches!(one, TakeDecision::Wait(_))), "{waiting:?}");
        let said = format!("{over:?}");
        assert!(said.contains("another name") && !said.contains("copies = 3"), "{said}");
        let is_taken = |one: &TakeDecision| matches!(one, TakeDecision::Take(SettledEntry::Part { lookup: None, .. }));
        assert!(!over.iter().any(is_taken), "{over:?}");
    }
}

#[test]
fn files_that_are_swapped_for_links_and_pipes_all_the_time_are_never_followed() {
    let farm = TestInbox::new();
    let (folder, file) = precious(&farm);
    let (inbox, stop) = (farm.inbox.clone(), std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false)));
    fs::create_dir(inbox.join("kit")).unwrap();
    let swapping = {
        let (inbox, folder, file, stop) = (inbox.clone(), folder.clone(), file.clone(), stop.clone());
        thread::spawn(move || {
            let mut round = 0_u64;
            while !stop.load(std::sync::atomic::Ordering::Relaxed) {
                swap(&inbox, &folder, &file, round);
                round += 1;
            }
            round
        })
    };
    let store_dir = farm.dir.path().join("store");
    let (looks, taken) = in_time(move || look_again_and_again(&inbox, &store_dir, Duration::from_secs(2)));
    stop.store(true, std::sync::atomic::Ordering::Relaxed);
    let rounds = swapping.join().unwrap();
    assert!(looks > 20 && rounds > 100, "{looks} looks, {rounds} swaps");
    // A file may be found before its writer has written to it.
    assert!(taken.iter().all(|bytes| bytes == b"theirs" || bytes.is_empty()), "{taken:?}");
    assert_eq!(files(&folder), ["a.stl"]);
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
}

/// Never writes through an entry that reappeared under that name: a pipe would block the writer forever.
fn write_new(path: &Path) -> std::io::Result<()> {
    std::io::Write::write_all(&mut fs::File::create_new(path)?, b"theirs")
}

/// One of several ways to replace a file or the folder above it.
fn swap(inbox: &Path, folder: &Path, file: &Path, round: u64) {
    let (part, kit) = (inbox.join("a.stl"), inbox.join("kit"));
    let _ = fs::remove_file(&part);
    let _ = fs::remove_file(&kit).or_else(|_| fs::remove_dir_all(&kit));
    let _ = match round % 4 {
        0 => write_new(&part),
        1 => symlink(file, &part),
        2 => fs::hard_link(file, &part),
        _ => pipe(&part),
    };
    let _ = match round % 2 {
        0 => symlink(folder, &kit),
        _ => fs::create_dir(&kit).and_then(|()| write_new(&kit.join("a.stl"))),
    };
}

/// Scans like the daemon, but takes everything at once, settled or not. Returns the number of scans and what was
/// stored.
fn look_again_and_again(inbox: &Path, store_dir: &Path, during: Duration) -> (usize, Vec<Vec<u8>>) {
    let store = ContentStore::open(store_dir).unwrap();
    let (began, mut looks, mut taken) = (std::time::Instant::now(), 0, Vec::new());
    while began.elapsed() < during {
        looks += 1;
        let Ok(listing) = scan_inbox(inbox, ScanLimits::default()) else { continue };
        let mut settler = SettleTracker::new(SettleRules { settle_secs: 0.0, unfinished_secs: 0.0, orphan_secs: 0.0 });
        let has_end = |path: &Path, _: &str| open_dropped_file(inbox, path).map(|_| true);
        settler.observe_scan(&listing.entries, 0.0, has_end);
        for ready in settler.observe_scan(&listing.entries, 1.0, has_end) {
            let Ok(claim) = claim_part(inbox, &ready) else { continue };
            if let Ok(stored) = store.store_claimed(&claim) {
                taken.push(fs::read(store.file_path(&stored.hash).unwrap()).unwrap());
            }
            let _ = release_claim(&claim, "");
        }
    }
    (looks, taken)
}
