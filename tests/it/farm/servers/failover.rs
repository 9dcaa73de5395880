//! Two daemons and one set of folders: one hangs, is suspended or dies, and another, perhaps a copy of it with the same
//! id, serves the folders meanwhile. Whoever comes back takes and prints nothing before its ledger knows what happened.

use std::{fs, path::Path, process::Command};

use ledger::{CommandKind, NewCommand, PartState};
use rustix::process::Signal;

use crate::support::{MACHINE, QUICK, TestFarm, block, signal, wait_until_or};

/// The factor by which a lease is shorter than in production.
const HURRY: &str = "10";

fn as_host(mut command: Command, name: &str) -> Command {
    command.env("NESTD_TEST_HOST", name).env("NESTD_TEST_HURRY", HURRY);
    command
}

fn start_as_host(farm: &mut TestFarm, name: &str) {
    let command = as_host(farm.command(&["run"]), name);
    farm.start_as(command);
}

/// A farm with a state folder of its own on the folders of another.
fn farm_on_folders_of(first: &TestFarm) -> TestFarm {
    let shared =
        ["inbox", "queue", "error", "archive"].map(|kind| format!("{kind} = {:?}\n", first.root().join(kind))).concat();
    let second = TestFarm::new(QUICK);
    let config = fs::read_to_string(second.config()).unwrap();
    fs::write(second.config(), format!("{config}[folders]\n{shared}")).unwrap();
    // The harness waits for this folder of a farm.
    fs::create_dir_all(second.folder("inbox")).unwrap();
    second
}

fn copy_folder(from: &Path, to: &Path) {
    let copied = Command::new("cp").arg("-a").arg(from).arg(to).status().unwrap();
    assert!(copied.success());
}

fn says(farm: &TestFarm, words: &str) {
    wait_until_or(&format!("the log says {words:?}"), 30.0, || farm.log(), || farm.log().contains(words));
}

fn order_flush(farm: &TestFarm) {
    let command = NewCommand {
        kind: CommandKind::Flush,
        machine: MACHINE.to_owned(),
        part: None,
        argument: Default::default(),
        asked_by: "a@test".to_owned(),
    };
    farm.query_ledger(async |ledger| ledger.submit_command(&command).await.unwrap());
}

/// The printer takes what is in the queue; returns the number of copies.
fn print_queue(farm: &TestFarm) -> usize {
    let files = farm.queued();
    files
        .into_iter()
        .map(|file| {
            let placed = build_file::read_build(&file, &build_file::ReadLimits::default()).unwrap().len();
            fs::remove_file(&file).unwrap();
            placed
        })
        .sum()
}

#[test]
fn a_farm_that_comes_back_after_a_copy_of_it_has_served_its_folders_prints_nothing_twice() {
    let mut first = TestFarm::new(QUICK);
    start_as_host(&mut first, "first");
    first.drop_part("a_x5.stl", &block(20.0, 20.0, 10.0));
    first.wait_for_parts(PartState::Waiting, 1);
    signal(first.pid(), Signal::STOP);
    let mut copy = farm_on_folders_of(&first);
    copy_folder(&first.root().join("state"), copy.root());
    start_as_host(&mut copy, "second");
    says(&copy, "The farm is open");
    assert!(!copy.log().contains("ERROR"), "{}", copy.log());
    copy.flush();
    first.wait_for_queued(1);
    assert_eq!(print_queue(&first), 5);
    copy.wait_for_parts(PartState::Built, 1);
    copy.stop();
    signal(first.pid(), Signal::CONT);
    order_flush(&first);
    says(&first, "The ledger is older than the folders");
    std::thread::sleep(std::time::Duration::from_secs(4));
    assert_eq!(print_queue(&first), 0, "printed twice\n{}", first.log());
    // What the alert asks for, to the letter.
    first.stop();
    let repaired = as_host(first.command(&["check", "--deep", "--repair"]), "first").output().unwrap();
    let said = String::from_utf8_lossy(&repaired.stdout).into_owned();
    assert!(said.contains("was published; its copies are taken in"), "{said}");
    start_as_host(&mut first, "first");
    first.wait_for_parts(PartState::Built, 1);
    first.drop_part("b.stl", &block(10.0, 20.0, 10.0));
    first.wait_for_parts(PartState::Waiting, 1);
    first.flush();
    first.wait_for_queued(1);
    assert_eq!(print_queue(&first), 1);
    first.stop();
}

#[test]
fn a_farm_whose_folders_are_taken_by_another_says_it_once_with_what_helps_and_forgets_it_when_it_stops() {
    let mut first = TestFarm::new(QUICK);
    start_as_host(&mut first, "first");
    says(&first, "The farm is open");
    first.drop_part("a.stl", &block(20.0, 20.0, 10.0));
    first.wait_for_parts(PartState::Waiting, 1);
    signal(first.pid(), Signal::STOP);
    let mut second = farm_on_folders_of(&first);
    start_as_host(&mut second, "second");
    says(&second, "The farm is open");
    assert!(!second.log().contains("--new-folder") && !second.log().contains("Mount"), "{}", second.log());
    signal(first.pid(), Signal::CONT);
    says(&first, "is served by another nestd");
    std::thread::sleep(std::time::Duration::from_secs(2));
    let said = first.nestd_ok(&["status"]);
    assert_eq!(said.matches("is served by another nestd").count(), 1, "{said}");
    assert!(!said.contains("Mount it again") && said.contains("goes on by itself"), "{said}");
    first.stop();
    let said = first.nestd_ok(&["status"]);
    assert!(!said.contains("is served by another nestd"), "{said}");
    start_as_host(&mut first, "first");
}

#[test]
fn a_farm_is_restored_on_a_new_server_after_the_old_one_died() {
    let mut dead = TestFarm::new(QUICK);
    start_as_host(&mut dead, "first");
    dead.drop_part("a_x5.stl", &block(20.0, 20.0, 10.0));
    dead.wait_for_parts(PartState::Waiting, 1);
    let backup = dead.root().join("backup");
    dead.nestd_ok(&["backup", backup.to_str().unwrap()]);
    let mut new = farm_on_folders_of(&dead);
    fs::create_dir(new.root().join("state")).unwrap();
    copy_folder(&dead.root().join("state/store"), &new.root().join("state"));
    dead.flush();
    dead.wait_for_queued(1);
    assert_eq!(print_queue(&dead), 5);
    // While it lives, its folders are its own.
    let alive = as_host(new.command(&["restore", backup.to_str().unwrap()]), "second").output().unwrap();
    let said = String::from_utf8_lossy(&alive.stderr).into_owned();
    assert!(!alive.status.success() && said.contains("Stop that one") && !said.contains("--new-folder"), "{said}");
    dead.kill();
    fs::rename(dead.root().join("state"), dead.root().join("gone")).unwrap();
    let restored = as_host(new.command(&["restore", backup.to_str().unwrap()]), "second").output().unwrap();
    assert!(restored.status.success(), "{restored:?}");
    let checked = as_host(new.command(&["check"]), "second").output().unwrap();
    let said = String::from_utf8_lossy(&checked.stdout).into_owned();
    assert!(!said.contains("another nestd"), "{said}");
    start_as_host(&mut new, "second");
    new.wait_for_parts(PartState::Built, 1);
    order_flush(&new);
    std::thread::sleep(std::time::Duration::from_secs(2));
    assert_eq!(print_queue(&dead), 0);
    new.stop();
}

#[test]
fn the_own_farm_is_known_from_a_container_with_another_host_name() {
    let mut farm = TestFarm::new(QUICK);
    start_as_host(&mut farm, "here");
    says(&farm, "The farm is open");
    std::thread::sleep(std::time::Duration::from_secs(1));
    for args in [&["check"][..], &["adopt", MACHINE]] {
        let output = as_host(farm.command(args), "0f3a").output().unwrap();
        let said = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert!(!said.contains("another nestd"), "{said}");
    }
    farm.stop();
}
