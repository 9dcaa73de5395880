//! What people ask with their parts is what is printed: copies, units, rules, priorities, late tickets and revisions, from
//! the hot folder to the build files of the real daemon.

use std::{
    collections::BTreeMap,
    fs,
    path::Path,
    time::{Duration, Instant},
};

use ledger::{BuildId, PartRow, PartState};

use crate::support::{QUICK, TestFarm, block, wait_until_or};

/// A copy in a build file: name of its file, longest side in tenths of a millimetre, orientation rule.
type PrintedCopy = (String, u32, String);

/// The copies of a build file, each with its number.
fn printed_copies(file: &Path) -> BTreeMap<PrintedCopy, u32> {
    let mut copies = BTreeMap::new();
    for placed in build_file::read_build(file, &Default::default()).unwrap() {
        let side = (placed.mesh.bounds().size().max_element() * 10.0).round() as u32;
        let copy = (placed.source_name.unwrap(), side, placed.orientation.unwrap_or_default());
        *copies.entry(copy).or_default() += 1;
    }
    copies
}

/// How often each file name stands in a build file.
fn printed_names(file: &Path) -> BTreeMap<String, u32> {
    let mut names = BTreeMap::new();
    for ((name, ..), copies) in printed_copies(file) {
        *names.entry(name).or_default() += copies;
    }
    names
}

fn waiting(farm: &TestFarm, name: &str) -> Option<PartRow> {
    farm.parts(PartState::Waiting).into_iter().find(|part| part.name == name)
}

fn await_that(farm: &TestFarm, what: &str, holds: impl FnMut() -> bool) {
    wait_until_or(what, 30.0, || farm.log(), holds);
}

/// The ticket that docs/technician.md shows, as somebody copies it.
fn readme_ticket() -> String {
    let readme = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/technician.md")).unwrap();
    let section = readme.split_once("**A ticket beside the part**").unwrap().1;
    let lines = section.lines().skip_while(|line| !line.starts_with("    ")).take_while(|line| !line.is_empty());
    lines.map(|line| format!("{line}\n")).collect()
}

#[test]
fn copies_of_names_of_the_readmes_ticket_and_of_a_ticket_ten_seconds_late_are_printed() {
    let farm = TestFarm::running(QUICK);
    farm.nestd_ok(&["pause", "test"]);
    farm.drop_part("late.stl", &block(10.0, 9.0, 8.0));
    let dropped = Instant::now();
    farm.drop_part("4x_neo.stl", &block(11.0, 9.0, 8.0));
    farm.drop_part("tool_4pcs.stl", &block(12.0, 9.0, 8.0));
    farm.drop_part("clipx4.stl", &block(13.0, 9.0, 8.0));
    farm.drop_bytes("bracket.stl.toml", readme_ticket().as_bytes());
    // One inch.
    farm.drop_part("bracket.stl", &block(1.0, 0.5, 0.5));
    farm.wait_for_parts(PartState::Waiting, 5);
    assert_eq!(waiting(&farm, "late.stl").unwrap().wanted_copies(), 1);
    let unclear = waiting(&farm, "clipx4.stl").unwrap().id;
    let asked = format!("How many copies? part {unclear} (clipx4.stl) is taken as 1");
    await_that(&farm, "it is asked", || {
        fs::read_to_string(farm.folder("inbox").join("STATUS.txt")).is_ok_and(|text| text.contains(&asked))
    });
    std::thread::sleep(Duration::from_secs(10).saturating_sub(dropped.elapsed()));
    farm.drop_bytes("late.stl.toml", b"copies = 3\n");
    await_that(&farm, "the late ticket counts", || {
        waiting(&farm, "late.stl").is_some_and(|part| part.wanted_copies() == 3)
    });
    farm.nestd_ok(&["resume", "test"]);
    farm.flush();
    let names = printed_names(&farm.wait_for_queued(1)[0]);
    let expected = [("4x_neo.stl", 4), ("bracket.stl", 10), ("clipx4.stl", 1), ("late.stl", 3), ("tool_4pcs.stl", 4)];
    assert_eq!(names, expected.map(|(name, copies)| (name.to_owned(), copies)).into());
}

#[test]
fn a_failed_build_comes_back_as_it_was_asked_a_revision_replaces_and_the_highest_priority_puts_nothing_out_in_vain() {
    let farm = TestFarm::running(QUICK);
    farm.drop_bytes("cover.stl.toml", b"copies = 3\nunit = \"inch\"\norientation = \"upright\"\n");
    farm.drop_part("cover.stl", &block(1.0, 0.8, 0.6));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    let first = printed_copies(&farm.wait_for_queued(1)[0]);
    assert_eq!(first, [(("cover.stl".to_owned(), 254, "upright".to_owned()), 3)].into());
    farm.wait_for_parts(PartState::Built, 1);
    for word in [
        "outcome 1 failed",
        "outcome 1 complete --bad 1=1",
        "outcome 1 interrupted --bad 1=1",
        "reprint b1",
        "requeue 1",
    ] {
        let refused = farm.nestd(&word.split(' ').collect::<Vec<_>>());
        let why = String::from_utf8_lossy(&refused.stderr);
        assert!(!refused.status.success() && why.contains("lies untouched"), "{word}: {refused:?}");
        assert_eq!((farm.queued().len(), farm.parts(PartState::Built).len()), (1, 1), "{word}");
    }
    farm.nestd_ok(&["outcome", "1", "failed", "--anyway"]);
    farm.wait_for_parts(PartState::Waiting, 1);

    farm.drop_part("brandt/hinge.stl", &block(10.0, 12.0, 14.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.drop_part("brandt/hinge.stl", &block(10.0, 12.0, 16.0));
    farm.wait_for_parts(PartState::Refused, 1);
    await_that(&farm, "the revision waits", || waiting(&farm, "hinge.stl").is_some());
    farm.flush();
    let file = farm.wait_for_queued(1).remove(0);
    let mut second = printed_copies(&file);
    let hinge = second.remove(&("hinge.stl".to_owned(), 160, "free".to_owned()));
    assert_eq!((&second, hinge), (&first, Some(1)), "the covers as they were, and the newer hinge alone");
    farm.wait_for_parts(PartState::Built, 2);

    farm.nestd_ok(&["pause", "test"]);
    // Eight cubes fill the volume.
    farm.drop_part("cube_x8.stl", &block(55.0, 55.0, 55.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    await_that(&farm, "the cubes stand in the open build", || {
        let statuses = farm.query_ledger(async |ledger| ledger.machine_statuses().await.unwrap());
        statuses[0].open.as_ref().is_some_and(|open| open.copies == Some(8))
    });
    farm.drop_bytes("urgent.stl.toml", b"priority = 100\n");
    farm.drop_part("urgent.stl", &block(4.0, 4.0, 4.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.nestd_ok(&["resume", "test"]);
    farm.flush();
    let names = printed_names(&farm.wait_for_queued(2)[1]);
    assert_eq!(names, [("cube_x8.stl".to_owned(), 8), ("urgent.stl".to_owned(), 1)].into());
}

#[test]
fn overdue_parts_that_come_one_after_another_are_one_build_that_fires_by_itself() {
    let farm = TestFarm::running(&format!("{QUICK}[trigger]\ngather_secs = 4\n"));
    for (name, side) in [("a", 10.0), ("b", 11.0)] {
        farm.drop_bytes(&format!("{name}.stl.toml"), b"due = 2020-01-01\n");
        farm.drop_part(&format!("{name}.stl"), &block(side, 9.0, 8.0));
        await_that(&farm, "it waits", || waiting(&farm, &format!("{name}.stl")).is_some());
        // Less than it gathers; without gathering the first part would be in a build by itself.
        std::thread::sleep(Duration::from_secs(1));
    }
    let names = printed_names(&farm.wait_for_queued(1)[0]);
    assert_eq!(names, [("a.stl".to_owned(), 1), ("b.stl".to_owned(), 1)].into());
    let build = farm.query_ledger(async |ledger| ledger.find_build(BuildId(1)).await.unwrap().unwrap());
    assert_eq!(build.fired_by, "due");
}

#[test]
fn a_day_is_shown_as_it_was_given_wherever_the_farm_is() {
    let mut farm = TestFarm::new(QUICK);
    let config = fs::read_to_string(farm.config()).unwrap();
    fs::write(farm.config(), format!("time_zone = \"Pacific/Kiritimati\"\n{config}")).unwrap();
    farm.start();
    farm.drop_bytes("a.stl.toml", b"due = 2098-12-24\n");
    farm.drop_part("a.stl", &block(10.0, 9.0, 8.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert_eq!(part.terms.due_at.unwrap().to_string(), "2098-12-24T09:59:59.000Z");
    let shown = farm.nestd_ok(&["show", &part.id.to_string()]);
    assert!(shown.contains("2098-12-24") && !shown.contains("2098-12-25"), "{shown}");
    let status = farm.nestd_ok(&["status"]);
    assert!(status.contains("2098-12-24"), "{status}");
}
