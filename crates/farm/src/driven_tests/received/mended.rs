//! A mesh that is not closed is mended when somebody says yes, and never in silence; the mended mesh is what is printed, each time.

use ledger::{CommandArgument, CommandKind, PartId, PartRow, PartState, RefusalCause};
use ledger_fixtures::ToldWords;

use crate::{
    AlertKind,
    driven_tests::{
        HandDrivenFarm, QUICK, block,
        printed::reprints::{change, published, tell},
        received::units::write_into_ledger,
        stl,
    },
};

/// The part of these tests is a block of 10 x 8 x 6 mm, of which a triangle of a face is lost.
fn torn_block() -> Vec<u8> {
    let mut bytes = stl(&block(10.0, 8.0, 6.0));
    bytes.truncate(84 + 50 * 11);
    bytes[80..84].copy_from_slice(&11_u32.to_le_bytes());
    bytes
}

fn drop_torn(farm: &mut HandDrivenFarm) -> PartRow {
    farm.drop_bytes("torn_x2.stl", &torn_block());
    farm.wait_for_parts(PartState::Refused, 1).remove(0)
}

fn mend(farm: &mut HandDrivenFarm, part: PartId) -> String {
    change(farm, CommandKind::Retry, part, CommandArgument { mend: true, ..CommandArgument::default() }, "")
}

fn row(farm: &HandDrivenFarm, part: PartId) -> PartRow {
    farm.ask(async |ledger| ledger.find_part(part).await.unwrap().unwrap())
}

/// Each copy in this build file is the whole block, closed.
fn assert_whole(farm: &HandDrivenFarm, build: usize, copies: usize) {
    let placed = build_file::read_build(&farm.queued()[build], &build_file::ReadLimits::default()).unwrap();
    assert_eq!(placed.len(), copies);
    for copy in placed {
        assert!(copy.mesh.defects().is_closed());
        assert!((copy.mesh.volume_mm3() - 480.0).abs() < 0.01, "{}", copy.mesh.volume_mm3());
    }
}

#[test]
fn a_mesh_that_can_be_mended_is_refused_with_what_would_be_done_and_is_printed_mended_after_a_yes() {
    let mut farm = HandDrivenFarm::open(QUICK);
    let part = drop_torn(&mut farm);
    assert_eq!(part.refused.refusal, Some(RefusalCause::Mendable));
    for said in ["3 open edges", "1 hole of at most", "1 triangle added", "0.4800 cm³", "`nestd mend 1`"] {
        assert!(part.refused.reason.contains(said), "{said}: {}", part.refused.reason);
    }
    assert!(mend(&mut farm, part.id).contains("its mesh is mended"));
    let waiting = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert_eq!((waiting.owed.copies, waiting.measures.triangles), (2, Some(12)));
    assert_eq!((waiting.mending.mend_allowed_by.as_str(), waiting.mending.mended_hash.len()), ("ann@farm", 64));
    assert!(waiting.warnings.contains("The mesh was mended, as ann@farm allows: 1 hole"), "{}", waiting.warnings);
    let events = farm.ask(async |ledger| ledger.events_of_part(part.id).await.unwrap());
    let told: Vec<&str> = events.iter().map(|event| event.detail.as_str()).collect();
    assert!(told.iter().any(|detail| detail.contains("ann@farm says that its mesh may be mended")), "{told:?}");
    assert!(told.iter().any(|detail| detail.contains("1 triangle added")), "{told:?}");
    farm.pass_secs(2.0);
    let left = intake::files_below(&farm.folder("error")).unwrap();
    assert!(!left.iter().any(|file| file.to_string_lossy().contains("torn")), "it is not refused any more: {left:?}");
    published(&mut farm, 1);
    assert_whole(&farm, 0, 2);
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn it_is_mended_the_same_after_a_restart_a_failed_print_an_issue_once_more_and_a_reprint() {
    let mut farm = HandDrivenFarm::open(QUICK);
    let part = drop_torn(&mut farm);
    mend(&mut farm, part.id);
    let hash = farm.wait_for_parts(PartState::Waiting, 1).remove(0).mending.mended_hash;
    farm.stop();
    farm.start();
    let build = published(&mut farm, 1);
    farm.forget_meshes();
    tell(&farm, build, ledger::PrintOutcome::Failed);
    let again = published(&mut farm, 2);
    farm.forget_meshes();
    farm.ask(async |ledger| ledger.requeue_build(again, "ann").await.unwrap());
    farm.wait_for_queued(3);
    farm.forget_meshes();
    let target = ledger::ReprintTarget::Part(part.id, Some(1));
    farm.ask(async |ledger| ledger.reprint_copies(&target, "ann").await.unwrap());
    published(&mut farm, 4);
    for (build, copies) in [(0, 2), (1, 2), (2, 2), (3, 1)] {
        assert_whole(&farm, build, copies);
    }
    assert_eq!(row(&farm, part.id).mending.mended_hash, hash);
}

#[test]
fn read_again_without_a_yes_it_is_refused_again() {
    let mut farm = HandDrivenFarm::open(QUICK);
    let part = drop_torn(&mut farm);
    farm.order_and_wait(CommandKind::Retry, Some(part.id));
    farm.pass_secs(3.0);
    let again = row(&farm, part.id);
    assert_eq!((again.state, again.file.reads), (PartState::Refused, 2));
    assert_eq!(again.mending, ledger::PartMending::default());
}

#[test]
fn a_setting_or_a_ticket_says_yes_beforehand_and_the_part_says_so() {
    let mut farm = HandDrivenFarm::open(&format!("mesh_errors = \"repair\"\n{QUICK}"));
    farm.drop_bytes("torn.stl", &torn_block());
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert_eq!(part.mending.mend_allowed_by, ledger::MEND_BY_SETTING);
    assert!(part.warnings.contains("as mesh_errors of its machine allows"), "{}", part.warnings);
    // An open box is no mistake of which one could be certain.
    let mut open = stl(&block(20.0, 20.0, 30.0));
    open.truncate(84 + 50 * 10);
    open[80..84].copy_from_slice(&10_u32.to_le_bytes());
    farm.drop_bytes("open.stl", &open);
    let refused = farm.wait_for_parts(PartState::Refused, 1).remove(0);
    assert_eq!(refused.refused.refusal, Some(RefusalCause::NotClosed));
    assert!(refused.refused.reason.contains("It is not mended, because"), "{}", refused.refused.reason);
    published(&mut farm, 1);
    assert_whole(&farm, 0, 1);

    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_bytes("torn.stl.toml", b"mend = true\n");
    farm.drop_bytes("torn.stl", &torn_block());
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert_eq!(part.mending.mend_allowed_by, ledger::MEND_BY_TICKET);
    assert!(part.warnings.contains("as its ticket allows"), "{}", part.warnings);
}

#[test]
fn a_part_that_is_mended_otherwise_than_recorded_is_not_printed_before_a_person_says_so() {
    let mut farm = HandDrivenFarm::open(QUICK);
    let part = drop_torn(&mut farm);
    mend(&mut farm, part.id);
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.pass_secs(2.0);
    write_into_ledger(&farm, "UPDATE part SET mended_hash = 'another'");
    farm.forget_meshes();
    farm.order(CommandKind::Flush, None);
    farm.pass_until("it waits for a person", |farm| farm.has_alert(AlertKind::Question));
    assert!(farm.queued().is_empty());
    assert!(row(&farm, part.id).owed.question.contains("is not mended now as it was"));
    farm.order_and_wait(CommandKind::Confirm, Some(part.id));
    farm.pass_until("it is read anew", |farm| {
        farm.parts(PartState::Waiting).iter().any(|p| p.owed.question.is_empty())
    });
    published(&mut farm, 1);
    assert_whole(&farm, 0, 2);
}

#[test]
fn what_was_not_refused_for_its_mesh_is_not_mended_and_a_mended_part_stays_so_on_another_machine() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.write_profile("other", &format!("mesh_errors = \"warn\"\n{QUICK}"));
    farm.reload();
    farm.drop_part("whole.stl", &block(5.0, 5.0, 5.0));
    let whole = farm.wait_for_parts(PartState::Waiting, 1).remove(0).id;
    change(&mut farm, CommandKind::Cancel, whole, CommandArgument::default(), "");
    let argument = CommandArgument { mend: true, ..CommandArgument::default() };
    let command = ledger::NewCommand {
        kind: CommandKind::Retry,
        machine: String::new(),
        part: Some(whole),
        argument,
        asked_by: "ann@farm".to_owned(),
    };
    let id = farm.submit_command(&command);
    let answer = |farm: &HandDrivenFarm| farm.ask(async |ledger| ledger.find_command(id).await.unwrap().unwrap());
    farm.pass_until("it is answered", |farm| answer(farm).answered_at.is_some());
    assert!(answer(&farm).answer.contains("not refused because of its mesh"), "{}", answer(&farm).answer);
    farm.drop_bytes("torn_x2.stl", &torn_block());
    farm.pass_until("it is refused", |farm| farm.parts(PartState::Refused).len() == 2);
    let torn = farm.parts(PartState::Refused).iter().map(|part| part.id).max().unwrap();
    mend(&mut farm, torn);
    farm.wait_for_parts(PartState::Waiting, 1);
    change(&mut farm, CommandKind::Move, torn, CommandArgument::default(), "other");
    let moved = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert_eq!((moved.machine.as_str(), moved.measures.triangles, moved.owed.size_differs), ("other", Some(12), false));
}
