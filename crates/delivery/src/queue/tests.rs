//! Tests on real folders. A crash is a panic between two steps: like a kill, it runs no cleanup.

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

fn queue() -> (tempfile::TempDir, QueueFolder) {
    let dir = tempfile::tempdir().unwrap();
    let queue = QueueFolder::open(dir.path().join("queue/mjf")).unwrap();
    (dir, queue)
}

fn stage(queue: &QueueFolder, name: &str) {
    queue.stage(name, Box::new(|file| Ok(file.write_all(name.as_bytes())?))).unwrap();
}

fn stage_all(queue: &QueueFolder) {
    for name in [BUILD, REPORT, PICTURE] {
        stage(queue, name);
    }
}

/// What a printer sees: names without a dot.
fn visible(queue: &QueueFolder) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(queue.folder_path())
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
    assert_eq!(queue.state(BUILD).unwrap(), FileState::Staged);
    assert_eq!(queue.publish(BUILD).unwrap(), PublishOutcome::PublishedNow);
    assert_eq!(visible(&queue), [BUILD, PICTURE, REPORT]);
    assert_eq!(fs::read_to_string(queue.published_path(BUILD)).unwrap(), BUILD);
    assert_eq!(queue.state(BUILD).unwrap(), FileState::Visible);
    assert_eq!(queue.publish(BUILD).unwrap(), PublishOutcome::AlreadyPublished);
}

#[test]
fn a_build_that_the_printer_took_is_not_published_again() {
    let (_dir, queue) = queue();
    stage_all(&queue);
    queue.publish(BUILD).unwrap();
    fs::remove_file(queue.published_path(BUILD)).unwrap();
    assert_eq!(queue.state(BUILD).unwrap(), FileState::Gone);
    assert_eq!(queue.publish(BUILD).unwrap(), PublishOutcome::AlreadyPublished);
    assert_eq!(visible(&queue), [PICTURE, REPORT]);
}

/// Stops a publication at its `stop`-th step; returns whether it reached that step.
fn stopped_at(queue: &QueueFolder, stop: usize) -> bool {
    let mut steps = 0;
    let run = || {
        queue.publish_with_hook(BUILD, &mut || {
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
            if printer_takes_it_at_once && queue.state(BUILD).unwrap() == FileState::Visible {
                // Its sidecars are published before it.
                assert_eq!(visible(&queue), [BUILD, PICTURE, REPORT], "stop {stop}");
                fs::remove_file(queue.published_path(BUILD)).unwrap();
                printed += 1;
            }
            // A new daemon finds the row `verified`.
            let queue = QueueFolder::open(queue.folder_path()).unwrap();
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
        let was_published = queue.state(BUILD).unwrap() == FileState::Visible;
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
    assert!(matches!(queue.stage(BUILD, Box::new(|_| Ok(()))), Err(QueueError::NameTaken(_))));
    assert_eq!(fs::read_to_string(queue.published_path(BUILD)).unwrap(), "another");
    assert_eq!(visible(&queue), [BUILD]);
}

#[test]
fn a_file_that_could_not_be_written_whole_is_not_staged() {
    let (_dir, queue) = queue();
    stage(&queue, BUILD);
    let failed = queue
        .stage(BUILD, Box::new(|file| Ok(file.write_all(b"half").and(Err(io::Error::other("the disk is full")))?)));
    assert!(matches!(failed, Err(QueueError::Write { .. })), "{failed:?}");
    // What was staged before is still whole.
    assert_eq!(fs::read_to_string(queue.staged_path(BUILD)).unwrap(), BUILD);
    let killed = catch_unwind(AssertUnwindSafe(|| {
        queue.stage(
            REPORT,
            Box::new(|file| {
                file.write_all(b"half")?;
                panic!("killed")
            }),
        )
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
    fs::rename(queue.folder_path(), &away).unwrap();
    assert!(matches!(queue.state(BUILD), Err(QueueError::Unavailable { .. })));
    fs::create_dir(queue.folder_path()).unwrap();
    assert!(matches!(queue.publish(BUILD), Err(QueueError::Unavailable { .. })));
    let other = QueueFolder::open(queue.folder_path()).unwrap();
    assert_ne!(other.id(), queue.id());
    assert!(matches!(queue.discard(BUILD), Err(QueueError::Unavailable { .. })));
    fs::remove_dir_all(queue.folder_path()).unwrap();
    fs::rename(&away, queue.folder_path()).unwrap();
    assert_eq!(QueueFolder::open(queue.folder_path()).unwrap().id(), queue.id());
    assert_eq!(queue.publish(BUILD).unwrap(), PublishOutcome::PublishedNow);
}

#[test]
fn an_empty_marker_is_made_anew() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join(".nestd-queue"), "").unwrap();
    assert_eq!(QueueFolder::open(dir.path()).unwrap().id().len(), 32);
}

#[test]
fn only_leftovers_of_ours_are_swept() {
    let (_dir, queue) = queue();
    stage_all(&queue);
    fs::write(queue.folder_path().join(".20261119T000000Z_mjf-5200_000007.build.3mf.half"), "x").unwrap();
    for name in [".printer.lock", ".x.part", "20261119T000000Z_mjf-5200_000006.build.3mf"] {
        fs::write(queue.folder_path().join(name), "x").unwrap();
    }
    let swept = queue.sweep(&[BUILD.to_owned()]).unwrap();
    assert_eq!(swept, [".20261119T000000Z_mjf-5200_000007.build.3mf.half"]);
    assert_eq!(queue.sweep(&[]).unwrap().len(), 3);
    assert_eq!(fs::read_dir(queue.folder_path()).unwrap().count(), 4);
}

#[test]
fn a_read_only_queue_is_an_error_that_names_it() {
    let (_dir, queue) = queue();
    fs::set_permissions(queue.folder_path(), fs::Permissions::from_mode(0o500)).unwrap();
    let result = queue.stage(BUILD, Box::new(|_| Ok(())));
    fs::set_permissions(queue.folder_path(), fs::Permissions::from_mode(0o700)).unwrap();
    // The superuser can write anyway.
    assert!(result.is_ok() || matches!(&result, Err(QueueError::Io { what: "create", .. })), "{result:?}");
}
