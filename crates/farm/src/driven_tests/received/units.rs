//! A part keeps the size in which it was read first, whatever is read again after the unit of its machine changed.

use ledger::{CommandArgument, CommandKind, PartEdit, PartId, PartState, PrintOutcome, ReprintTarget};
use ledger_fixtures::ToldWords;

use crate::{
    AlertKind,
    driven_tests::{
        HandDrivenFarm, MACHINE, QUICK, block,
        printed::reprints::{change, contents, edit, published, tell},
    },
};

/// The volume of the part of these tests as it was read first.
const VOLUME: &str = "120.00";

/// The part of these tests: no unit is said of it.
fn drop_block(farm: &mut HandDrivenFarm) -> PartId {
    farm.drop_part("a_x2.stl", &block(4.0, 5.0, 6.0));
    farm.wait_for_parts(PartState::Waiting, 1).remove(0).id
}

/// The unit of the machine's file is another one from now on.
fn change_unit(farm: &mut HandDrivenFarm, with_restart: bool) {
    farm.write_profile(MACHINE, &format!("unit = \"inch\"\n{QUICK}"));
    match with_restart {
        true => {
            farm.stop();
            farm.start();
        }
        false => farm.reload(),
    }
}

/// Every copy in this build file has the size that was read first.
fn assert_size(farm: &HandDrivenFarm, build: usize, copies: usize, what: &str) {
    let built = contents(farm, build);
    assert_eq!(built.len(), copies, "{what}: {built:?}");
    assert!(built.iter().all(|(.., volume)| volume == VOLUME), "{what}: {built:?}");
}

#[test]
fn a_waiting_part_keeps_its_size_when_the_unit_of_its_machine_changes() {
    for with_restart in [false, true] {
        let mut farm = HandDrivenFarm::open(QUICK);
        drop_block(&mut farm);
        change_unit(&mut farm, with_restart);
        farm.forget_meshes();
        published(&mut farm, 1);
        assert_size(&farm, 0, 2, &format!("restart: {with_restart}"));
        farm.assert_nothing_lost_or_doubled();
    }
}

#[test]
fn copies_of_a_failed_print_and_a_build_that_is_issued_again_keep_their_size() {
    for with_restart in [false, true] {
        let mut farm = HandDrivenFarm::open(QUICK);
        let part = drop_block(&mut farm);
        let build = published(&mut farm, 1);
        change_unit(&mut farm, with_restart);
        farm.forget_meshes();
        tell(&farm, build, PrintOutcome::Failed);
        let again = published(&mut farm, 2);
        assert_size(&farm, 1, 2, "failed");
        farm.forget_meshes();
        farm.ask(async |ledger| ledger.requeue_build(again, "ann").await.unwrap());
        farm.wait_for_queued(3);
        assert_size(&farm, 2, 2, "requeue");
        farm.forget_meshes();
        farm.ask(async |ledger| ledger.reprint_copies(&ReprintTarget::Part(part, Some(1)), "ann").await.unwrap());
        published(&mut farm, 4);
        assert_size(&farm, 3, 1, "reprint");
    }
}

#[test]
fn a_part_that_is_moved_keeps_its_size_on_a_machine_with_another_unit() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.write_profile("other", &format!("unit = \"inch\"\n{QUICK}"));
    farm.reload();
    let part = drop_block(&mut farm);
    change(&mut farm, CommandKind::Move, part, CommandArgument::default(), "other");
    let row = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert_eq!((row.machine.as_str(), row.size_mm()), ("other", Some([4.0, 5.0, 6.0])));
    change(&mut farm, CommandKind::Move, part, CommandArgument::default(), MACHINE);
    farm.wait_for_parts(PartState::Waiting, 1);
    published(&mut farm, 1);
    assert_size(&farm, 0, 2, "moved to and fro");
}

#[test]
fn a_part_that_was_read_and_is_taken_back_or_edited_keeps_its_size_unless_a_unit_is_said() {
    let mut farm = HandDrivenFarm::open(QUICK);
    let part = drop_block(&mut farm);
    change(&mut farm, CommandKind::Cancel, part, CommandArgument::default(), "");
    change_unit(&mut farm, true);
    farm.order_and_wait(CommandKind::Retry, Some(part));
    let row = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert_eq!(row.size_mm(), Some([4.0, 5.0, 6.0]), "taken back");
    let unit = PartEdit { unit: Some(build_file::LengthUnit::Centimeter), ..PartEdit::default() };
    change(&mut farm, CommandKind::Edit, part, edit(unit), "");
    let row = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert_eq!(row.size_mm(), Some([40.0, 50.0, 60.0]), "a unit was said");
    assert_eq!(row.owed.question, "");
    change_unit(&mut farm, true);
    published(&mut farm, 1);
    assert_eq!(contents(&farm, 0)[0].2, "120000.00");
}

#[test]
fn a_part_that_is_read_in_another_unit_is_not_warned_of_for_the_size_that_it_had() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a.stl", &block(0.5, 0.4, 0.3));
    let row = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert!(row.warnings.contains(build_file::SIZE_WARNING), "{}", row.warnings);
    let unit = PartEdit { unit: Some(build_file::LengthUnit::Inch), ..PartEdit::default() };
    change(&mut farm, CommandKind::Edit, row.id, edit(unit), "");
    let row = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert!(!row.warnings.contains(build_file::SIZE_WARNING), "{}", row.warnings);
}

#[test]
fn a_part_that_was_refused_before_it_was_read_is_read_in_the_unit_of_its_machine_when_it_is_taken_back() {
    let mut farm = HandDrivenFarm::open(&format!("unit = \"meter\"\n{QUICK}"));
    farm.drop_part("a.stl", &block(4.0, 5.0, 6.0));
    let part = farm.wait_for_parts(PartState::Refused, 1).remove(0).id;
    farm.write_profile(MACHINE, QUICK);
    farm.reload();
    farm.order_and_wait(CommandKind::Retry, Some(part));
    let row = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert_eq!(row.size_mm(), Some([4.0, 5.0, 6.0]));
}

#[test]
fn a_part_that_a_restored_ledger_has_forgotten_keeps_its_size() {
    let mut farm = HandDrivenFarm::open(QUICK);
    let backup = farm.write_backup("backup.db");
    drop_block(&mut farm);
    farm.stop();
    farm.write_profile(MACHINE, &format!("unit = \"inch\"\n{QUICK}"));
    farm.restore(&backup);
    farm.start();
    farm.wait_for_parts(PartState::Waiting, 1);
    published(&mut farm, 1);
    assert_size(&farm, 0, 2, "restored");
}

/// Changes the ledger behind the farm's back.
pub(super) fn write_into_ledger(farm: &HandDrivenFarm, change: &'static str) {
    farm.ask(async |ledger| {
        let file = ledger.file().unwrap().display().to_string();
        let pool = sqlx::SqlitePool::connect(&format!("sqlite://{file}")).await.unwrap();
        sqlx::query(change).execute(&pool).await.unwrap();
        pool.close().await;
    });
}

#[test]
fn a_part_that_an_earlier_nestd_read_is_read_in_the_unit_that_gives_its_size() {
    for unit in ["millimeter", "centimeter"] {
        let mut farm = HandDrivenFarm::open(&format!("unit = \"{unit}\"\n{QUICK}"));
        let part = drop_block(&mut farm);
        let size = farm.parts(PartState::Waiting)[0].size_mm();
        write_into_ledger(&farm, "UPDATE part SET read_unit = NULL");
        change_unit(&mut farm, true);
        farm.forget_meshes();
        published(&mut farm, 1);
        let volume = if unit == "centimeter" { "120000.00" } else { VOLUME };
        assert_eq!(contents(&farm, 0)[0].2, volume);
        farm.ask(async |ledger| ledger.reprint_copies(&ReprintTarget::Part(part, Some(1)), "ann").await.unwrap());
        farm.write_profile("other", &format!("unit = \"foot\"\n{QUICK}"));
        farm.reload();
        farm.pass_secs(3.0);
        change(&mut farm, CommandKind::Move, part, CommandArgument::default(), "other");
        let row = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
        assert_eq!((row.size_mm(), row.owed.question.as_str()), (size, ""));
        assert!(row.measures.read_unit.is_some(), "from now on it has one");
    }
}

/// A farm in which a part has another size than when it was first read, as if a reader had changed.
fn farm_with_other_size(build: bool) -> (HandDrivenFarm, PartId) {
    let mut farm = HandDrivenFarm::open(QUICK);
    let part = drop_block(&mut farm);
    farm.drop_part("b.stl", &block(10.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.pass_secs(3.0);
    farm.stop();
    farm.start();
    write_into_ledger(&farm, "UPDATE part SET size_x_mm = 5 WHERE name = 'a_x2.stl'");
    farm.forget_meshes();
    if build {
        farm.order(CommandKind::Flush, None);
        farm.wait_for_queued(1);
        assert_eq!(contents(&farm, 0).len(), 1, "the other part is printed");
    } else {
        farm.forget_layout(MACHINE);
        farm.drop_part("c.stl", &block(11.0, 10.0, 10.0));
        farm.wait_for_parts(PartState::Waiting, 3);
    }
    farm.pass_until("a person is asked", |farm| farm.has_alert(AlertKind::Question));
    let row = farm.ask(async |ledger| ledger.find_part(part).await.unwrap().unwrap());
    assert_eq!(row.size_mm(), Some([5.0, 5.0, 6.0]), "what was read first stays");
    assert!(row.owed.question.contains("is 4.00 x 5.00 x 6.00 mm now, and was 5.00 x"), "{}", row.owed.question);
    (farm, part)
}

#[test]
fn a_part_of_another_size_is_not_printed_before_a_person_says_that_it_is_right() {
    for build in [false, true] {
        let (mut farm, part) = farm_with_other_size(build);
        farm.order_and_wait(CommandKind::Flush, None);
        farm.pass_secs(5.0);
        let is_printed = |farm: &HandDrivenFarm| {
            let queued = farm.queued();
            (0..queued.len()).any(|at| contents(farm, at).iter().any(|(id, ..)| *id == part.to_string()))
        };
        assert!(!is_printed(&farm));
        farm.order_and_wait(CommandKind::Confirm, Some(part));
        farm.pass_until("it is read anew", |farm| farm.parts(PartState::Claimed).is_empty());
        farm.pass_secs(3.0);
        let row = farm.ask(async |ledger| ledger.find_part(part).await.unwrap().unwrap());
        assert_eq!((row.size_mm(), row.owed.size_differs), (Some([4.0, 5.0, 6.0]), false));
        assert!(!farm.has_alert(AlertKind::Question));
        farm.order_and_wait(CommandKind::Flush, None);
        farm.pass_until("it is printed", is_printed);
        farm.assert_nothing_lost_or_doubled();
    }
}

#[test]
fn a_part_of_another_size_is_mended_by_its_unit() {
    let (mut farm, part) = farm_with_other_size(false);
    let unit = PartEdit { unit: Some(build_file::LengthUnit::Centimeter), ..PartEdit::default() };
    change(&mut farm, CommandKind::Edit, part, edit(unit), "");
    farm.pass_until("it is read anew", |farm| farm.parts(PartState::Claimed).is_empty());
    let row = farm.ask(async |ledger| ledger.find_part(part).await.unwrap().unwrap());
    assert_eq!((row.size_mm(), row.owed.question.as_str()), (Some([40.0, 50.0, 60.0]), ""));
}

#[test]
fn a_part_whose_size_differs_when_it_is_moved_waits_for_a_person() {
    let (mut farm, part) = farm_with_other_size(false);
    write_into_ledger(&farm, "UPDATE part SET question = '', size_differs = 0");
    farm.write_profile("other", QUICK);
    farm.reload();
    change(&mut farm, CommandKind::Move, part, CommandArgument::default(), "other");
    farm.pass_until("it is read", |farm| farm.parts(PartState::Claimed).is_empty());
    let row = farm.ask(async |ledger| ledger.find_part(part).await.unwrap().unwrap());
    assert!(row.owed.size_differs && row.size_mm() == Some([5.0, 5.0, 6.0]));
}
