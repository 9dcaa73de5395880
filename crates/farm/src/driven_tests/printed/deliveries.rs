//! Builds that are delivered as something else than a 3MF whose copies share their meshes: published once, and followed as that one is.

use std::{
    fs,
    path::{Path, PathBuf},
};

use build_file::{DeliveryKind, ReadLimits};
use ledger::{
    BuildId, BuildState, CommandKind, InQueueError, LedgerError, OperatorWord, PartState, PrintOutcome, ToldOutcome,
};

use ledger_fixtures::ToldWords;

use super::printers::published;
use crate::{
    AlertKind,
    driven_tests::{HandDrivenFarm, MACHINE, QUICK, block},
};

const OTHERS: [DeliveryKind; 3] = [DeliveryKind::Expanded, DeliveryKind::Stl, DeliveryKind::Parts];

fn machine(kind: DeliveryKind, options: &str) -> String {
    format!("{QUICK}{options}[delivery]\nkind = \"{}\"\n", kind.name())
}

/// A farm with one published build of five copies, among them some of a part whose numbers need more than 32 bits.
fn one_build(kind: DeliveryKind) -> (HandDrivenFarm, PathBuf) {
    let mut farm = HandDrivenFarm::open(&machine(kind, "archive_builds_days = 30\n"));
    farm.drop_part("a_x4.stl", &sample_parts::bracket(30.0, 12.0, 3.0, 4.0));
    let mut obj = String::new();
    let mesh = sample_parts::cuboid(glam::DVec3::new(10.0 / 3.0, 12.1, 14.7));
    mesh.vertices().iter().for_each(|v| obj += &format!("v {} {} {}\n", v.x, v.y, v.z));
    mesh.triangles().iter().for_each(|t| obj += &format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1));
    farm.drop_bytes("b.obj", obj.as_bytes());
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.order(CommandKind::Flush, None);
    let queued = farm.wait_for_queued(1).remove(0);
    farm.pass_secs(1.0);
    (farm, queued)
}

/// Part, copy, bounds and words of everything in a build file.
fn contents(file: &Path) -> Vec<String> {
    let placed = build_file::read_build(file, &ReadLimits::default()).unwrap();
    let text = |p: &build_file::PlacedMesh| {
        let bounds = p.mesh.bounds_at(&p.pose);
        format!("{:?} {:?} {:.2} {:.2} {:?}", p.part_number, p.copy, bounds.min, bounds.max, p.source_hash)
    };
    let mut all: Vec<String> = placed.iter().map(text).collect();
    all.sort();
    all
}

/// What a printer sees of a build.
fn visible(farm: &HandDrivenFarm) -> Vec<String> {
    let names =
        fs::read_dir(farm.folder("queue")).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.filter(|name| !name.starts_with('.')).collect();
    names.sort();
    names
}

fn tell(farm: &HandDrivenFarm, outcome: PrintOutcome) {
    let told = ToldOutcome::new(outcome, "", "ann@farm");
    farm.say(&OperatorWord::Outcome(BuildId(1), told), false).unwrap();
}

#[test]
fn each_kind_is_published_once_and_its_file_is_what_the_ledger_says() {
    for kind in OTHERS {
        let (farm, file) = one_build(kind);
        let name = file.file_name().unwrap().to_str().unwrap();
        assert!(name.ends_with(kind.ending()), "{name}");
        assert_eq!(contents(&file).len(), 5);
        let builds = visible(&farm).iter().filter(|name| build_file::build_file_stem(name).is_some()).count();
        let tables = visible(&farm).iter().filter(|name| name.ends_with(".placements.csv")).count();
        assert_eq!((builds, tables), (1, usize::from(kind == DeliveryKind::Stl)), "{:?}", visible(&farm));
        let build = published(&farm).remove(0);
        assert_eq!(build.staged.file_name.as_deref(), Some(name));
        assert!(build.measures.clearance_proved_mm >= Some(2.0 - 1e-6), "{:?}", build.measures.clearance_proved_mm);
        farm.assert_nothing_lost_or_doubled();
    }
}

#[test]
fn the_file_of_each_kind_is_taken_altered_copied_and_taken_back_as_a_3mf_is() {
    for kind in OTHERS {
        let (mut farm, file) = one_build(kind);
        let (bytes, name) = (fs::read(&file).unwrap(), file.file_name().unwrap().to_str().unwrap().to_owned());
        let told = |farm: &mut HandDrivenFarm, text: &str| {
            farm.pass_until(text, |farm| farm.alert_text(AlertKind::QueueAltered).contains(text));
        };
        let over = |farm: &mut HandDrivenFarm| {
            farm.pass_until("it is over", |farm| !farm.has_alert(AlertKind::QueueAltered));
        };
        // Altered.
        fs::write(&file, [&bytes[..bytes.len() - 1], b"x"].concat()).unwrap();
        told(&mut farm, "is not the file that was proved as build 1");
        fs::write(&file, &bytes).unwrap();
        over(&mut farm);
        // Copied, under a name that tells nothing.
        let copy = file.with_file_name("job-7.dat");
        fs::copy(&file, &copy).unwrap();
        told(&mut farm, &format!("job-7.dat at test holds the copies of build 1 (published), whose file is {name}"));
        let withdraw = OperatorWord::Withdraw(BuildId(1), String::new());
        let refused = farm.say(&withdraw, false);
        assert!(matches!(refused, Err(LedgerError::InQueue(InQueueError::Copied { .. }))), "{kind:?}: {refused:?}");
        fs::remove_file(&copy).unwrap();
        farm.pass_until("its end is asked for", |farm| farm.alert_text(AlertKind::QueueAltered).contains("is gone"));
        farm.say(&OperatorWord::SeenTo(BuildId(1)), false).unwrap();
        over(&mut farm);
        // Taken back, with all that lay beside it.
        farm.say(&withdraw, false).unwrap();
        farm.pass_until("it is withdrawn", |farm| visible(farm).is_empty());
        farm.wait_for_parts(PartState::Waiting, 2);
        farm.ask(async |ledger| ledger.resume_machine(MACHINE, "a@test").await.unwrap());
        farm.order(CommandKind::Flush, None);
        // Taken by the printer.
        let next = farm.wait_for_queued(1).remove(0);
        farm.pass_secs(1.0);
        assert!(next.to_str().unwrap().ends_with(kind.ending()));
        fs::remove_file(&next).unwrap();
        farm.pass_until("it was taken", |farm| published(farm)[0].place.taken_at.is_some());
        farm.assert_ledger_agrees_with_folders();
    }
}

#[test]
fn a_build_of_each_kind_is_issued_once_more_from_its_kept_file() {
    for kind in OTHERS {
        let (mut farm, file) = one_build(kind);
        let before = contents(&file);
        tell(&farm, PrintOutcome::Complete);
        for entry in fs::read_dir(farm.folder("archive")).unwrap().map(|entry| entry.unwrap().path()) {
            for original in ["a_x4.stl", "b.obj"].map(|name| entry.join(name)).iter().filter(|file| file.is_file()) {
                fs::remove_file(original).unwrap();
            }
        }
        farm.stop();
        farm.start();
        farm.ask(async |ledger| ledger.requeue_build(BuildId(1), "ann").await.unwrap());
        let again = farm.wait_for_queued(2).remove(1);
        farm.pass_secs(1.0);
        assert_eq!(contents(&again), before, "{kind:?}");
        assert!(!farm.has_alert(AlertKind::FileDamaged), "{kind:?}");
    }
}

#[test]
fn a_ledger_that_is_older_than_its_folders_learns_what_was_printed_from_records_and_files_of_each_kind() {
    for (kind, has_record) in OTHERS.into_iter().flat_map(|kind| [(kind, true), (kind, false)]) {
        let mut farm = HandDrivenFarm::open(&machine(kind, ""));
        farm.drop_part("a_x2.stl", &block(20.0, 15.0, 10.0));
        farm.wait_for_parts(PartState::Waiting, 1);
        let backup = farm.write_backup("before.sqlite");
        farm.order(CommandKind::Flush, None);
        let file = farm.wait_for_queued(1).remove(0);
        farm.pass_secs(1.0);
        farm.stop();
        if !has_record {
            for entry in fs::read_dir(farm.folder("archive")).unwrap().map(|entry| entry.unwrap().path()) {
                for hidden in fs::read_dir(&entry).into_iter().flatten().map(|file| file.unwrap().path()) {
                    if hidden.to_str().unwrap().contains(".nestd-build") {
                        fs::remove_file(hidden).unwrap();
                    }
                }
            }
        }
        farm.restore(&backup);
        farm.start();
        farm.pass_secs(5.0);
        let builds = published(&farm);
        let name = file.file_name().unwrap().to_str();
        assert_eq!(builds[0].staged.file_name.as_deref(), name, "{kind:?}, record: {has_record}");
        assert_eq!((builds.len(), farm.parts(PartState::Built).len(), farm.queued().len()), (1, 1, 1), "{kind:?}");
        farm.assert_ledger_agrees_with_folders();
    }
}

#[test]
fn a_proved_build_is_made_again_when_its_machine_is_delivered_another_kind() {
    let waits = "approve = \"always\"\n";
    let mut farm = HandDrivenFarm::open(&machine(DeliveryKind::Shared, waits));
    farm.drop_part("a_x2.stl", &block(20.0, 15.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.order(CommandKind::Flush, None);
    let proved =
        |farm: &HandDrivenFarm| farm.ask(async |ledger| ledger.builds_in_state(BuildState::Verified).await.unwrap());
    farm.pass_until("a build is proved", |farm| proved(farm).len() == 1);
    for kind in [DeliveryKind::Expanded, DeliveryKind::Stl, DeliveryKind::Parts, DeliveryKind::Shared] {
        let before = proved(&farm).remove(0);
        farm.write_profile(MACHINE, &machine(kind, waits));
        farm.reload();
        farm.pass_until("it is made again", |farm| {
            proved(farm).first().is_some_and(|now| now.staged.file_hash != before.staged.file_hash)
        });
        let now = proved(&farm).remove(0);
        assert!(now.id == before.id && now.staged.file_name.unwrap().ends_with(kind.ending()));
    }
    let events = farm.ask(async |ledger| ledger.events_of_build(BuildId(1)).await.unwrap());
    assert!(
        events.iter().any(|event| event.detail.contains("builds are delivered as expanded, and it is shared")),
        "{events:#?}"
    );
    farm.say(&OperatorWord::Release { build: BuildId(1), seen: None }, false).unwrap();
    farm.wait_for_queued(1);
    farm.pass_secs(1.0);
    let hidden = fs::read_dir(farm.folder("queue")).unwrap().filter(|entry| {
        let name = entry.as_ref().unwrap().file_name().into_string().unwrap();
        name.starts_with('.') && name != ".nestd-queue" && !name.starts_with(".nestd-")
    });
    assert_eq!(hidden.count(), 0, "nothing of the other kinds is left");
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn a_build_in_the_queue_of_a_machine_that_is_delivered_another_kind_now_is_told() {
    let (mut farm, _) = one_build(DeliveryKind::Shared);
    farm.write_profile(MACHINE, &machine(DeliveryKind::Stl, "archive_builds_days = 30\n"));
    farm.reload();
    farm.pass_until("it is told", |farm| {
        farm.alert_text(AlertKind::QueueAltered).contains("`nestd withdraw 1` takes it out")
    });
}
