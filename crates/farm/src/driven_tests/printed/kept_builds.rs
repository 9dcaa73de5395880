//! Copies of published build files in the archive, and builds that are issued once more from them.

use std::{fs, path::PathBuf};

use ledger::{BuildId, CommandKind, PartState};
use ledger_fixtures::ToldWords;

use crate::{
    AlertKind,
    driven_tests::{HandDrivenFarm, QUICK, block},
};

/// A farm that keeps build files, with one published build of five copies.
fn farm_with_build() -> (HandDrivenFarm, PathBuf) {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}archive_builds_days = 30\n"));
    farm.drop_part("a_x4.stl", &sample_parts::bracket(30.0, 12.0, 3.0, 4.0));
    farm.drop_part("b.stl", &block(10.0, 12.0, 14.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.order(CommandKind::Flush, None);
    let queued = farm.wait_for_queued(1).remove(0);
    farm.pass_secs(1.0);
    let kept = farm.folder("archive").join("builds").join(queued.file_name().unwrap());
    (farm, kept)
}

/// Removes the originals from the archive, as their retention or a person does.
fn remove_originals(farm: &HandDrivenFarm) {
    for entry in fs::read_dir(farm.folder("archive")).unwrap().map(|entry| entry.unwrap().path()) {
        for original in ["a_x4.stl", "b.stl"].map(|name| entry.join(name)).iter().filter(|file| file.is_file()) {
            fs::remove_file(original).unwrap();
        }
    }
}

/// Copies, bounds and places of everything in a build file.
fn contents(farm: &HandDrivenFarm, build: usize) -> Vec<String> {
    let placed = build_file::read_build(&farm.queued()[build], &build_file::ReadLimits::default()).unwrap();
    let text = |p: &build_file::PlacedMesh| {
        let bounds = p.mesh.bounds_at(&p.pose);
        format!("{:?} {:?} {:.3} {:.3}", p.part_number, p.copy, bounds.min, bounds.max)
    };
    let mut all: Vec<String> = placed.iter().map(text).collect();
    all.sort();
    all
}

#[test]
fn a_build_is_issued_once_more_from_its_kept_file_when_nobody_has_the_originals_any_more() {
    let (mut farm, kept) = farm_with_build();
    remove_originals(&farm);
    farm.stop();
    farm.start();
    let second = farm.ask(async |ledger| ledger.requeue_build(BuildId(1), "ann").await.unwrap());
    farm.wait_for_queued(2);
    farm.pass_secs(1.0);
    assert_eq!(contents(&farm, 0).len(), 5);
    assert_eq!(contents(&farm, 0), contents(&farm, 1));
    assert!(!farm.has_alert(AlertKind::FileDamaged), "nobody is asked for a file");
    // Once more, from the file of the build that was made from a file.
    fs::remove_file(kept).unwrap();
    farm.ask(async |ledger| ledger.requeue_build(second, "ann").await.unwrap());
    farm.wait_for_queued(3);
    farm.pass_secs(1.0);
    assert_eq!(contents(&farm, 0), contents(&farm, 2));
    assert_eq!(farm.violations().iter().filter(|found| !found.contains("in build 1 ")).collect::<Vec<_>>(), [""; 0]);
}

#[test]
fn a_kept_file_that_was_changed_is_found_and_not_printed() {
    let (mut farm, kept) = farm_with_build();
    farm.assert_ledger_agrees_with_folders();
    let mut bytes = fs::read(&kept).unwrap();
    bytes.push(0);
    fs::write(&kept, bytes).unwrap();
    assert!(farm.violations().iter().any(|found| found.contains("is not the file that was proved as build 1")));
    remove_originals(&farm);
    farm.stop();
    farm.start();
    farm.ask(async |ledger| ledger.requeue_build(BuildId(1), "ann").await.unwrap());
    farm.pass_until("the originals are asked for", |farm| farm.has_alert(AlertKind::FileDamaged));
    assert_eq!(farm.queued().len(), 1);
}

#[test]
fn a_printer_that_changes_its_file_does_not_change_the_kept_one() {
    let (farm, kept) = farm_with_build();
    let before = fs::read(&kept).unwrap();
    assert_eq!(before, fs::read(&farm.queued()[0]).unwrap());
    fs::write(&farm.queued()[0], b"taken").unwrap();
    assert_eq!(fs::read(&kept).unwrap(), before);
}

#[test]
fn a_build_is_published_although_its_file_cannot_be_kept() {
    let mut farm = HandDrivenFarm::closed(&format!("{QUICK}archive_builds_days = 0\n"));
    fs::create_dir_all(farm.folder("archive")).unwrap();
    fs::write(farm.folder("archive").join("builds"), b"in the way").unwrap();
    farm.start();
    farm.drop_part("a.stl", &block(10.0, 12.0, 14.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.order(CommandKind::Flush, None);
    farm.wait_for_queued(1);
}
