//! A machine whose file is edited under its proved builds: what does not fit it any more comes into no queue.

use std::{fs, path::Path};

use glam::DVec3;
use ledger::{BuildRow, BuildState, CommandKind, OperatorWord, PartState};
use settings::load_settings;

use super::printers::{published, queue, take_down, visible};
use crate::{
    AlertKind, awaits_release,
    driven_tests::{
        HandDrivenFarm, MACHINE, QUICK, block,
        hand_driven_farm::farm_files::{assert_each_copy_once, list_build_files},
    },
    fate_of_queued, preview_release,
};

const APPROVED: &str = "orientation = \"fixed\"\nwall_margin_mm = 0\napprove = \"always\"\n";

fn edit_machine(farm: &HandDrivenFarm, options: &str, from: &str, to: &str) {
    let text = format!("{QUICK}{options}");
    assert!(text.contains(from), "{text}");
    farm.write_profile(MACHINE, &text.replace(from, to));
}

fn proved(farm: &HandDrivenFarm) -> Vec<BuildRow> {
    farm.ask(async |ledger| ledger.builds_in_state(BuildState::Verified).await.unwrap())
}

fn release(farm: &HandDrivenFarm, build: &BuildRow) {
    farm.say(&OperatorWord::Release { build: build.id, seen: None }, false).unwrap();
}

/// The highest corner of what stands in a build file, mm.
fn extent_mm(file: &Path) -> DVec3 {
    let placed = build_file::read_build(file, &build_file::ReadLimits::default()).unwrap();
    placed.iter().map(|placed| placed.mesh.bounds_at(&placed.pose).max).fold(DVec3::ZERO, DVec3::max)
}

/// A farm with two blocks side by side in a proved build that waits for a yes.
fn two_blocks(options: &str) -> (HandDrivenFarm, BuildRow) {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}{options}"));
    for name in ["a.stl", "b.stl"] {
        farm.drop_part(name, &block(50.0, 50.0, 40.0));
    }
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.order(CommandKind::Flush, None);
    farm.pass_until("a build is proved", |farm| proved(farm).len() == 1);
    let build = proved(&farm).remove(0);
    (farm, build)
}

#[test]
fn a_proved_build_that_does_not_fit_its_machine_any_more_is_made_again_and_not_published() {
    for restarts in [false, true] {
        let (mut farm, build) = two_blocks(APPROVED);
        assert!(build.measures.height_mm < Some(41.0), "side by side");
        if restarts {
            farm.stop();
        }
        edit_machine(&farm, APPROVED, "[120, 120, 120]", "[60, 60, 120]");
        if restarts {
            farm.start();
        } else {
            farm.reload();
        }
        farm.pass_until("it is made again", |farm| {
            proved(farm).first().is_some_and(|now| now.measures.height_mm > Some(80.0))
        });
        let again = proved(&farm).remove(0);
        assert_eq!(again.id, build.id);
        let events = farm.ask(async |ledger| ledger.events_of_build(build.id).await.unwrap());
        let why = "the machine has changed since it was proved: the space that may be filled ends at 60 x 60 x 120 mm";
        assert!(events.iter().any(|event| event.detail.contains(why)), "{events:#?}");
        release(&farm, &again);
        let file = farm.wait_for_queued(1).remove(0);
        assert!(extent_mm(&file).cmple(DVec3::new(60.0, 60.0, 120.0)).all());
        assert_each_copy_once(&[file], 2);
        farm.assert_nothing_lost_or_doubled();
    }
}

#[test]
fn a_proved_build_that_is_about_to_be_made_again_waits_for_no_yes_and_shows_no_figures() {
    let (farm, build) = two_blocks(APPROVED);
    assert!(awaits_release(&farm.profiles()[MACHINE], &build));
    edit_machine(&farm, APPROVED, "[120, 120, 120]", "[60, 60, 120]");
    let config = farm.root().join("config/nestd.toml");
    let smaller = load_settings(Some(&config), Some(farm.root())).unwrap().profiles[MACHINE].clone();
    assert!(!awaits_release(&smaller, &build));
    let now = farm.date();
    let preview = farm.ask(async |ledger| preview_release(ledger, &smaller, &build, now).await.unwrap());
    let said = preview.sentences(&smaller.time_zone).join(" ");
    assert!(said.starts_with(&format!("Build {} is made again, for the machine has changed", build.id)), "{said}");
    assert!(!said.contains("mm high"), "{said}");
}

#[test]
fn a_released_build_under_which_the_machine_changes_while_its_printer_is_down_is_not_published() {
    let changes = [
        ("clearance_mm = 2.0", "clearance_mm = 9.0", "parts are to be 9 mm apart"),
        ("wall_margin_mm = 0", "wall_margin_mm = 5", "begins at 5, 5, 0 mm"),
        ("wall_margin_mm = 0", "wall_margin_mm = 0\nclearance_z_extra_mm = 3", "raised by up to 3 mm"),
        (
            "wall_margin_mm = 0",
            "wall_margin_mm = 0\nkeep_out = [{ min = [0, 0, 0], max = [40, 40, 40] }]",
            "no part may be placed between 0, 0, 0 and 40, 40, 40 mm",
        ),
    ];
    for (from, to, why) in changes {
        let (mut farm, build) = two_blocks(APPROVED);
        take_down(&farm, MACHINE);
        farm.tick();
        release(&farm, &build);
        farm.pass_secs(5.0);
        edit_machine(&farm, APPROVED, from, to);
        farm.reload();
        farm.pass_until("it is to be made again", |farm| proved(farm).is_empty());
        let events = farm.ask(async |ledger| ledger.events_of_build(build.id).await.unwrap());
        assert!(events.iter().any(|event| event.detail.contains(why)), "{why}: {events:#?}");
        assert!(farm.queued().is_empty());
    }
}

#[test]
fn a_proved_build_of_a_machine_that_has_more_room_or_another_ceiling_above_it_stays_as_it_is() {
    for (from, to) in [
        ("[120, 120, 120]", "[130, 125, 120]"),
        ("[120, 120, 120]", "[120, 120, 45]"),
        ("clearance_mm = 2.0", "clearance_mm = 1.0"),
    ] {
        let (mut farm, build) = two_blocks(APPROVED);
        edit_machine(&farm, APPROVED, from, to);
        farm.reload();
        farm.pass_secs(5.0);
        assert_eq!(proved(&farm)[0].staged, build.staged, "{to}");
        release(&farm, &build);
        farm.wait_for_queued(1);
    }
}

#[test]
fn a_part_that_has_no_place_in_the_smaller_machine_waits_again_and_a_person_is_told() {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}{APPROVED}"));
    for number in 1..=2 {
        farm.drop_part(&format!("{number}.stl"), &block(100.0, 50.0, 40.0));
        farm.wait_for_parts(PartState::Waiting, 1);
        farm.order(CommandKind::Flush, None);
        farm.pass_until("a build is proved", |farm| proved(farm).len() == number);
    }
    let builds = proved(&farm);
    edit_machine(&farm, APPROVED, "[120, 120, 120]", "[80, 80, 120]");
    farm.reload();
    farm.pass_until("both are told", |farm| {
        builds.iter().all(|build| farm.alert_text(AlertKind::BuildFailed).contains(&format!("build {}", build.id)))
    });
    assert!(farm.queued().is_empty() && proved(&farm).is_empty());
    for build in &builds {
        let row = farm.ask(async |ledger| ledger.find_build(build.id).await.unwrap().unwrap());
        assert_eq!((row.state, row.attempts), (BuildState::Failed, 2), "another attempt finds no place either");
        assert_eq!((row.measures.height_mm, row.measures.layers, row.measures.lower_bound_mm), (None, None, None));
    }
    let told = farm.alert_text(AlertKind::BuildFailed);
    assert_eq!(told.matches("none of its copies has a place in the machine as it is now").count(), 2, "{told}");
    assert!(farm.status_text().contains("PAUSED"), "{}", farm.status_text());
    // They are refused then, and nothing says that they wait.
    farm.wait_for_parts(PartState::Refused, 2);
    farm.pass_secs(10.0);
    assert!(farm.status_text().contains("Nothing waits."), "{}", farm.status_text());
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn a_build_that_is_issued_once_more_is_proved_for_the_machine_as_it_is_now() {
    let (mut farm, build) = two_blocks(APPROVED);
    release(&farm, &build);
    let file = farm.wait_for_queued(1).remove(0);
    farm.wait_for_parts(PartState::Built, 2);
    fs::rename(file, farm.root().join("taken.build.3mf")).unwrap();
    farm.say(&OperatorWord::Requeue(build.id), false).unwrap();
    edit_machine(&farm, APPROVED, "[120, 120, 120]", "[60, 60, 120]");
    farm.reload();
    farm.pass_until("it is proved anew", |farm| !proved(farm).is_empty());
    let again = proved(&farm).remove(0);
    let events = farm.ask(async |ledger| ledger.events_of_build(again.id).await.unwrap());
    let told = format!("not as build {} was, for the machine has changed", build.id);
    assert!(events.iter().any(|event| event.detail.contains(&told)), "{events:#?}");
    release(&farm, &again);
    let file = farm.wait_for_queued(1).remove(0);
    assert!(extent_mm(&file).cmple(DVec3::new(60.0, 60.0, 120.0)).all(), "{}", extent_mm(&file));
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn a_build_in_a_queue_that_does_not_fit_any_more_is_told_goes_to_no_other_printer_and_can_be_withdrawn() {
    let printers =
        "orientation = \"fixed\"\nwall_margin_mm = 0\n[[printer]]\nname = \"left\"\n[[printer]]\nname = \"right\"\n";
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}{printers}"));
    for name in ["a.stl", "b.stl"] {
        farm.drop_part(name, &block(50.0, 50.0, 40.0));
    }
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.order(CommandKind::Flush, None);
    farm.wait_for_parts(PartState::Built, 2);
    assert_eq!(visible(&farm), [1, 0]);
    let build = published(&farm).remove(0);
    edit_machine(&farm, printers, "[120, 120, 120]", "[60, 60, 120]");
    farm.reload();
    farm.pass_until("it is told", |farm| farm.has_alert(AlertKind::QueueAltered));
    let told = farm.alert_text(AlertKind::QueueAltered);
    assert!(told.contains("60 x 60 x 120 mm") && told.contains(&format!("`nestd withdraw {}`", build.id)), "{told}");
    take_down(&farm, "left");
    let profile = farm.profiles()[MACHINE].clone();
    let fate = farm.ask(async |ledger| fate_of_queued(ledger, &profile, "left").await.unwrap());
    assert!(fate.contains(&format!("Build {} goes to no other one, for the machine has changed", build.id)), "{fate}");
    farm.pass_secs(30.0);
    assert_eq!(visible(&farm), [1, 0], "it does not go to the other printer");
    let status = farm.folder("inbox").join("STATUS.txt");
    let is_there = |_: &HandDrivenFarm| fs::read_to_string(&status).unwrap().contains("must not be printed as it is");
    farm.pass_until("the hot folder says so", is_there);
    farm.say(&OperatorWord::Withdraw(build.id, String::new()), false).unwrap();
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.ask(async |ledger| ledger.resume_machine(MACHINE, "ann").await.unwrap());
    farm.tick();
    farm.order(CommandKind::Flush, None);
    farm.pass_until("it is at the other printer", |farm| visible(farm) == [0, 1]);
    farm.pass_until("it is told no more", |farm| !farm.has_alert(AlertKind::QueueAltered));
    let file = list_build_files(&queue(&farm, "right")).remove(0);
    assert!(extent_mm(&file).cmple(DVec3::new(60.0, 60.0, 120.0)).all());
    assert_each_copy_once(&[file], 2);
    farm.assert_ledger_agrees_with_folders();
}
