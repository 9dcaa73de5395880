//! Folders that disappear: they are "unavailable", never "all files deleted". And folders that two daemons want: the
//! second daemon is refused, with the name of the first one.

use std::{fs, process::Stdio, time::Duration};

use ledger::PartState;

use crate::support::{QUICK, TestFarm, block, wait_until_or};

fn says(farm: &TestFarm, words: &str) {
    wait_until_or(&format!("the log says {words:?}"), 20.0, || farm.log(), || farm.log().contains(words));
}

/// Runs the daemon until it ends by itself; returns its output.
fn refused(farm: &TestFarm) -> String {
    let child = farm.command(&["run"]).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let pid = child.id() as i32;
    let watchdog = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_secs(20));
        let _ =
            rustix::process::kill_process(rustix::process::Pid::from_raw(pid).unwrap(), rustix::process::Signal::KILL);
    });
    let output = child.wait_with_output().unwrap();
    drop(watchdog);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_second_daemon_on_the_same_farm_is_refused_and_names_who_serves_it() {
    let farm = TestFarm::running(QUICK);
    let output_text = refused(&farm);
    let host = rustix::system::uname().nodename().to_string_lossy().into_owned();
    assert!(output_text.contains(&format!("process {} on {host} since ", farm.pid())), "{output_text}");
}

#[test]
fn a_daemon_with_another_ledger_is_refused_a_hot_folder_or_queue_that_is_served() {
    let first = TestFarm::running(QUICK);
    for kind in ["inbox", "queue"] {
        let other = TestFarm::new(QUICK);
        let config = fs::read_to_string(other.config()).unwrap();
        let folder = first.root().join(kind);
        fs::write(other.config(), format!("{config}[folders]\n{kind} = {folder:?}\n")).unwrap();
        let output_text = refused(&other);
        let served = format!("{} is served by another nestd: process {}", first.folder(kind).display(), first.pid());
        assert!(output_text.contains(&served) && output_text.contains("Stop that one"), "{output_text}");
    }
    first.drop_part("a.stl", &block(20.0, 20.0, 10.0));
    first.wait_for_parts(PartState::Waiting, 1);
}

#[test]
fn a_folder_of_a_daemon_that_was_killed_is_free_at_once() {
    let mut first = TestFarm::running(QUICK);
    first.kill();
    let mut other = TestFarm::new(QUICK);
    let config = fs::read_to_string(other.config()).unwrap();
    fs::write(other.config(), format!("{config}[folders]\ninbox = {:?}\n", first.root().join("inbox"))).unwrap();
    fs::create_dir_all(other.folder("inbox")).unwrap();
    other.start();
    fs::write(first.folder("inbox").join("a.stl"), crate::support::stl(&block(20.0, 20.0, 10.0))).unwrap();
    other.wait_for_parts(PartState::Waiting, 1);
}

#[test]
fn an_empty_directory_in_the_place_of_the_hot_folder_is_unavailable_until_the_folder_is_back() {
    let farm = TestFarm::running(QUICK);
    let (inbox, away) = (farm.folder("inbox"), farm.root().join("away"));
    farm.drop_part("a.stl", &block(20.0, 20.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    fs::rename(&inbox, &away).unwrap();
    says(&farm, "The hot folder is unavailable");
    fs::create_dir(&inbox).unwrap();
    let replaced = "is not the folder that was there before: its marker .nestd-owner is missing";
    wait_until_or("status says so", 20.0, || farm.log(), || farm.nestd_ok(&["status"]).contains(replaced));
    fs::write(inbox.join("b.stl"), crate::support::stl(&block(10.0, 20.0, 10.0))).unwrap();
    std::thread::sleep(Duration::from_secs(2));
    assert_eq!(farm.parts(PartState::Waiting).len(), 1, "a part was taken out of an empty mount point");
    fs::remove_file(inbox.join("b.stl")).unwrap();
    fs::remove_dir(&inbox).unwrap();
    fs::rename(&away, &inbox).unwrap();
    says(&farm, "Resolved: test: The hot folder is unavailable");
    farm.drop_part("c.stl", &block(20.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    assert!(farm.parts(PartState::Refused).is_empty());
}

#[test]
fn a_hot_folder_that_was_replaced_on_purpose_is_taken_when_somebody_says_so() {
    let farm = TestFarm::running(QUICK);
    let inbox = farm.folder("inbox");
    says(&farm, "The farm is open");
    fs::rename(&inbox, farm.root().join("old")).unwrap();
    fs::create_dir(&inbox).unwrap();
    says(&farm, "if it was replaced or emptied on purpose: touch");
    farm.reload();
    says(&farm, "The configuration was read again");
    std::thread::sleep(Duration::from_secs(5));
    assert_eq!(fs::read_dir(&inbox).unwrap().count(), 0, "a reload took an empty mount point for the hot folder");
    fs::write(inbox.join(".nestd-owner"), "").unwrap();
    says(&farm, "Resolved: test: The hot folder is unavailable");
    farm.drop_part("a.stl", &block(20.0, 20.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
}

#[test]
fn a_build_is_not_staged_in_an_empty_directory_in_the_place_of_the_queue() {
    let farm = TestFarm::running(QUICK);
    farm.drop_part("a.stl", &block(20.0, 20.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    let (queue, away) = (farm.folder("queue"), farm.root().join("away"));
    wait_until_or("the queue is open", 10.0, || farm.log(), || queue.join(".nestd-queue").exists());
    fs::rename(&queue, &away).unwrap();
    fs::create_dir(&queue).unwrap();
    farm.flush();
    says(&farm, "The queue folder cannot be used");
    std::thread::sleep(Duration::from_secs(2));
    assert_eq!(fs::read_dir(&queue).unwrap().count(), 0, "something was written into an empty mount point");
    fs::remove_dir(&queue).unwrap();
    fs::rename(&away, &queue).unwrap();
    farm.wait_for_queued(1);
    farm.wait_for_parts(PartState::Built, 1);
}

#[test]
fn an_archive_or_error_folder_that_is_away_is_never_taken_for_an_empty_one() {
    let mut farm = TestFarm::running(QUICK);
    says(&farm, "The farm is open");
    let folders = ["archive", "error"].map(|kind| (farm.folder(kind), farm.root().join(format!("{kind}-away"))));
    for (folder, _) in &folders {
        wait_until_or("it is marked", 10.0, || farm.log(), || folder.join(".nestd-owner").exists());
    }
    farm.stop();
    for (folder, away) in &folders {
        fs::rename(folder, away).unwrap();
        fs::create_dir(folder).unwrap();
    }
    farm.start();
    says(&farm, "The archive cannot be used");
    says(&farm, "The error folder cannot be used");
    farm.drop_part("a.stl", &block(20.0, 20.0, 10.0));
    farm.drop_bytes("bad.stl", b"solid nonsense\nendsolid\n");
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.wait_for_parts(PartState::Refused, 1);
    farm.flush();
    std::thread::sleep(Duration::from_secs(3));
    assert!(farm.queued().is_empty(), "a build was published beside its archive");
    for (folder, away) in &folders {
        assert_eq!(fs::read_dir(folder).unwrap().count(), 0, "something was put into an empty mount point");
        fs::remove_dir(folder).unwrap();
        fs::rename(away, folder).unwrap();
    }
    farm.wait_for_queued(1);
    farm.wait_for_parts(PartState::Built, 1);
    let refused = farm.folder("error").join("bad.stl");
    wait_until_or("the refused file is put there", 60.0, || farm.log(), || refused.exists());
}
