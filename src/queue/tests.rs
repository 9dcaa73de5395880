//! Real folders; a crash is a panic between two steps, which like a kill runs nothing that would tidy up.

use std::{
    fs,
    io::{self, Write},
    os::unix::fs::PermissionsExt,
    panic::{AssertUnwindSafe, catch_unwind},
};

use super::*;

const BUILD: &str = "20261120T044900Z_mjf-5200_000042.build.3mf";
const REPORT: &str = "20261120T044900Z_mjf-5200_000042.report.json";
const PICTURE: &str = "20261120T044900Z_mjf-5200_000042.png";

fn queue() -> (tempfile::TempDir, Queue) {
    let dir = tempfile::tempdir().unwrap();
    let queue = Queue::open(dir.path().join("queue/mjf")).unwrap();
    (dir, queue)
}

fn stage(queue: &Queue, name: &str) {
    queue.stage(name, |file| file.write_all(name.as_bytes())).unwrap();
}

fn stage_all(queue: &Queue) {
    for name in [BUILD, REPORT, PICTURE] {
        stage(queue, name);
    }
}

/// What a printer sees: names without a dot.
fn visible(queue: &Queue) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(queue.dir())
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .filter(|n| !n.starts_with('.'))
        .collect();
    names.sort();
    names
}

#[test]
fn a_build_is_invisible_until_it_is_published_whole_with_its_sidecars() {
    let (_dir, queue) = queue();
    stage_all(&queue);
    assert_eq!(visible(&queue), [""; 0]);
    assert_eq!(queue.state(BUILD).unwrap(), StagedState::Staged);
    assert_eq!(queue.publish(BUILD).unwrap(), Published::Now);
    assert_eq!(visible(&queue), [BUILD, PICTURE, REPORT]);
    assert_eq!(fs::read_to_string(queue.published_path(BUILD)).unwrap(), BUILD);
    assert_eq!(queue.state(BUILD).unwrap(), StagedState::Published);
    assert_eq!(queue.publish(BUILD).unwrap(), Published::Before);
}

#[test]
fn a_build_that_the_printer_took_is_not_published_again() {
    let (_dir, queue) = queue();
    stage_all(&queue);
    queue.publish(BUILD).unwrap();
    fs::remove_file(queue.published_path(BUILD)).unwrap();
    assert_eq!(queue.state(BUILD).unwrap(), StagedState::Gone);
    assert_eq!(queue.publish(BUILD).unwrap(), Published::Before);
    assert_eq!(visible(&queue), [PICTURE, REPORT]);
}

/// Runs a publication that is stopped at its `stop`-th step; says whether it got there.
fn stopped_at(queue: &Queue, stop: usize) -> bool {
    let mut steps = 0;
    let run = || {
        queue.publish_stepwise(BUILD, &mut || {
            steps += 1;
            assert!(steps < stop, "stop here");
        })
    };
    catch_unwind(AssertUnwindSafe(run)).is_err()
}

#[test]
fn a_build_stopped_anywhere_is_published_exactly_once() {
    let mut stops = 0;
    for stop in 1.. {
        for printer_takes_it_at_once in [false, true] {
            let (_dir, queue) = queue();
            stage_all(&queue);
            if !stopped_at(&queue, stop) {
                assert!(stops >= 2 * 5, "only {stops} stops");
                return;
            }
            stops += 1;
            let mut printed = 0;
            if printer_takes_it_at_once && queue.state(BUILD).unwrap() == StagedState::Published {
                // Its sidecars came before it.
                assert_eq!(visible(&queue), [BUILD, PICTURE, REPORT], "stop {stop}");
                fs::remove_file(queue.published_path(BUILD)).unwrap();
                printed += 1;
            }
            // A new daemon finds the row `verified`.
            let queue = Queue::open(queue.dir()).unwrap();
            assert_eq!(queue.sweep(&[BUILD.to_owned()]).unwrap(), [""; 0]);
            queue.publish(BUILD).unwrap();
            printed += usize::from(queue.published_path(BUILD).exists());
            assert_eq!(printed, 1, "stop {stop}");
            assert!(visible(&queue).contains(&REPORT.to_owned()) && visible(&queue).contains(&PICTURE.to_owned()));
            assert!(!queue.staged_path(BUILD).exists());
        }
    }
}

#[test]
fn a_build_stopped_anywhere_can_be_discarded_while_it_is_not_published() {
    for stop in 1.. {
        let (_dir, queue) = queue();
        stage_all(&queue);
        if !stopped_at(&queue, stop) {
            return;
        }
        let was_published = queue.state(BUILD).unwrap() == StagedState::Published;
        assert_eq!(queue.discard(BUILD).unwrap(), !was_published);
        assert_eq!(visible(&queue).len(), if was_published { 3 } else { 0 }, "stop {stop}");
        assert!(!queue.staged_path(BUILD).exists());
    }
}

#[test]
fn nothing_in_the_queue_is_overwritten() {
    let (_dir, queue) = queue();
    stage_all(&queue);
    fs::write(queue.published_path(BUILD), "another").unwrap();
    assert!(matches!(queue.publish(BUILD), Err(QueueError::NameTaken(_))));
    assert!(matches!(queue.stage(BUILD, |_| io::Result::Ok(())), Err(QueueError::NameTaken(_))));
    assert_eq!(fs::read_to_string(queue.published_path(BUILD)).unwrap(), "another");
    assert_eq!(visible(&queue), [BUILD]);
}

#[test]
fn a_file_that_could_not_be_written_whole_is_not_staged() {
    let (_dir, queue) = queue();
    stage(&queue, BUILD);
    let failed = queue.stage(BUILD, |file| file.write_all(b"half").and(Err(io::Error::other("the disk is full"))));
    assert!(matches!(failed, Err(QueueError::Write { .. })), "{failed:?}");
    // What was staged before is still whole.
    assert_eq!(fs::read_to_string(queue.staged_path(BUILD)).unwrap(), BUILD);
    let killed = catch_unwind(AssertUnwindSafe(|| {
        queue.stage(REPORT, |file| -> io::Result<()> {
            file.write_all(b"half")?;
            panic!("killed")
        })
    }));
    assert!(killed.is_err() && !queue.staged_path(REPORT).exists());
    stage(&queue, REPORT);
    assert_eq!(fs::read_to_string(queue.staged_path(REPORT)).unwrap(), REPORT);
}

#[test]
fn a_queue_folder_that_was_unmounted_or_replaced_is_noticed() {
    let (dir, queue) = queue();
    stage_all(&queue);
    let away = dir.path().join("away");
    fs::rename(queue.dir(), &away).unwrap();
    assert!(matches!(queue.state(BUILD), Err(QueueError::Unavailable { .. })));
    fs::create_dir(queue.dir()).unwrap();
    assert!(matches!(queue.publish(BUILD), Err(QueueError::Unavailable { .. })));
    let other = Queue::open(queue.dir()).unwrap();
    assert_ne!(other.id(), queue.id());
    assert!(matches!(queue.discard(BUILD), Err(QueueError::Unavailable { .. })));
    fs::remove_dir_all(queue.dir()).unwrap();
    fs::rename(&away, queue.dir()).unwrap();
    assert_eq!(Queue::open(queue.dir()).unwrap().id(), queue.id());
    assert_eq!(queue.publish(BUILD).unwrap(), Published::Now);
}

#[test]
fn an_empty_marker_is_made_anew() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join(".nestd-queue"), "").unwrap();
    assert_eq!(Queue::open(dir.path()).unwrap().id().len(), 32);
}

#[test]
fn only_leftovers_of_ours_are_swept() {
    let (_dir, queue) = queue();
    stage_all(&queue);
    fs::write(queue.dir().join(".20261119T000000Z_mjf-5200_000007.build.3mf.half"), "x").unwrap();
    for name in [".printer.lock", ".x.part", "20261119T000000Z_mjf-5200_000006.build.3mf"] {
        fs::write(queue.dir().join(name), "x").unwrap();
    }
    let swept = queue.sweep(&[BUILD.to_owned()]).unwrap();
    assert_eq!(swept, [".20261119T000000Z_mjf-5200_000007.build.3mf.half"]);
    assert_eq!(queue.sweep(&[]).unwrap().len(), 3);
    assert_eq!(fs::read_dir(queue.dir()).unwrap().count(), 4);
}

#[test]
fn a_read_only_queue_is_an_error_that_names_it() {
    let (_dir, queue) = queue();
    fs::set_permissions(queue.dir(), fs::Permissions::from_mode(0o500)).unwrap();
    let result = queue.stage(BUILD, |_| io::Result::Ok(()));
    fs::set_permissions(queue.dir(), fs::Permissions::from_mode(0o700)).unwrap();
    // The superuser may write anyway.
    assert!(result.is_ok() || matches!(&result, Err(QueueError::Io { what: "create", .. })), "{result:?}");
}
