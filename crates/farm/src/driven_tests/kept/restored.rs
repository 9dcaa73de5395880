//! Ledgers that are put back to a time before copies were edited and printed, or orders came by request.

use std::fs;

use intake::{PutContents, ordered_claim_id};
use ledger::{
    AnsweredRequest, BuildState, CommandArgument, CommandKind, NewOrderRequest, OperatorWord, OrderedLine, PartEdit,
    PartId, PartState, PrintOutcome, ReprintTarget, ToldOutcome,
};

use crate::{
    driven_tests::{HandDrivenFarm, MACHINE, QUICK, block, printed::reprints::change, stl},
    note_order, update_order_notes,
};

fn publish(farm: &mut HandDrivenFarm, builds: usize) {
    farm.order(CommandKind::Flush, None);
    farm.wait_for_queued(builds);
    farm.pass_secs(1.0);
}

fn edit(farm: &HandDrivenFarm, part: PartId, copies: u32) {
    let edit = PartEdit { copies: Some(copies), ..PartEdit::default() };
    farm.ask(async |ledger| ledger.edit_part(part, &edit, "ann@farm").await.unwrap());
}

#[test]
fn a_restored_ledger_wants_at_least_the_copies_that_were_printed_since_and_holds_together() {
    type Since = fn(&mut HandDrivenFarm, PartId);
    let stories: [(&str, Since, PartState, u32); 4] = [
        (
            "more were wanted before the print",
            |farm, part| (edit(farm, part, 3), publish(farm, 1)).1,
            PartState::Built,
            3,
        ),
        (
            "more were wanted after the print",
            |farm, part| {
                publish(farm, 1);
                edit(farm, part, 3);
                publish(farm, 2);
            },
            PartState::Built,
            3,
        ),
        (
            "some of them were cancelled",
            |farm, part| {
                edit(farm, part, 5);
                farm.ask(async |ledger| ledger.cancel_copies(part, 2, "ann@farm").await.unwrap());
                publish(farm, 1);
            },
            PartState::Built,
            3,
        ),
        (
            "it was refused, taken back and wanted more often",
            |farm, part| {
                farm.order_and_wait(CommandKind::Cancel, Some(part));
                farm.order_and_wait(CommandKind::Retry, Some(part));
                farm.wait_for_parts(PartState::Waiting, 1);
                edit(farm, part, 4);
                publish(farm, 1);
            },
            PartState::Built,
            4,
        ),
    ];
    for (story, since, state, wanted) in stories {
        let mut farm = HandDrivenFarm::open(QUICK);
        farm.drop_part("a.stl", &block(10.0, 12.0, 14.0));
        let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0).id;
        let backup = farm.write_backup("backup");
        since(&mut farm, part);
        for _ in 0..2 {
            farm.stop();
            farm.restore(&backup);
            farm.start();
            farm.pass_secs(2.0);
            let parts = farm.parts(state);
            let found: Vec<u32> = parts.iter().map(|part| part.wanted_copies()).collect();
            assert_eq!(found, [wanted], "{story}");
            farm.assert_nothing_lost_or_doubled();
        }
    }
}

#[test]
fn what_was_decided_about_a_claim_that_still_stands_in_the_hot_folder_holds_after_a_restore() {
    type Decide = fn(&mut HandDrivenFarm);
    let stories: [(&str, Decide); 2] = [
        ("it is no part", |farm| {
            farm.drop_bytes("a.stl", b"solid nothing\nendsolid nothing\n");
        }),
        ("it was cancelled before it was read", |farm| {
            farm.drop_part("a.stl", &block(10.0, 12.0, 14.0));
            let part = farm.wait_for_parts(PartState::Claimed, 1).remove(0);
            farm.order(CommandKind::Cancel, Some(part.id));
        }),
    ];
    for (story, decide) in stories {
        let mut farm = HandDrivenFarm::open(QUICK);
        let backup = farm.write_backup("backup");
        // What is refused stays where it is claimed.
        let (error, aside) = (farm.folder("error"), farm.root().join("aside"));
        fs::rename(&error, &aside).unwrap();
        decide(&mut farm);
        farm.wait_for_parts(PartState::Refused, 1);
        farm.pass_secs(1.0);
        farm.stop();
        let _ = fs::remove_dir(&error);
        fs::rename(&aside, &error).unwrap();
        let told = farm.restore(&backup).doubts.join("\n");
        for _ in 0..2 {
            farm.start();
            farm.stop();
        }
        farm.start();
        farm.pass_secs(3.0);
        assert_eq!((farm.parts(PartState::Refused).len(), farm.parts(PartState::Waiting).len()), (1, 0), "{story}");
        assert!(told.contains("a.stl") && told.contains("is not printed"), "{story}: {told}");
        let refused = intake::files_below(&error).unwrap();
        assert_eq!(refused.iter().filter(|file| file.ends_with("a.stl")).count(), 1, "{story}: {refused:?}");
        let retried = farm.parts(PartState::Refused)[0].id;
        farm.order_and_wait(CommandKind::Retry, Some(retried));
        farm.pass_secs(2.0);
        farm.assert_ledger_agrees_with_folders();
    }
}

#[test]
fn the_copies_that_a_late_ticket_asked_for_are_named_with_a_remedy_that_brings_them_back() {
    // Whether the ledger knew the part before the ticket came.
    for is_known in [true, false] {
        let mut farm = HandDrivenFarm::open(QUICK);
        let mut backup = farm.write_backup("before");
        farm.drop_part("bracket.stl", &block(10.0, 12.0, 14.0));
        farm.wait_for_parts(PartState::Waiting, 1);
        if is_known {
            backup = farm.write_backup("known");
        }
        farm.drop_bytes("bracket.stl.toml", b"copies = 9\n");
        farm.pass_until("it is applied", |farm| farm.parts(PartState::Waiting)[0].wanted_copies() == 9);
        farm.pass_secs(1.0);
        farm.stop();
        let told = farm.restore(&backup).doubts.join("\n");
        assert!(told.contains("bracket.stl") && told.contains("9 copies of it were wanted then"), "{told}");
        farm.start();
        let part = farm.wait_for_parts(PartState::Refused, 1).remove(0).id;
        assert!(told.contains(&format!("`nestd retry {part}` takes it back")), "{told}");
        assert!(told.contains(&format!("`nestd edit {part} --copies 9`")), "{told}");
        farm.order_and_wait(CommandKind::Retry, Some(part));
        farm.wait_for_parts(PartState::Waiting, 1);
        edit(&farm, part, 9);
        publish(&mut farm, 1);
        farm.assert_nothing_lost_or_doubled();
    }
}

#[test]
fn of_a_part_that_is_built_a_restore_names_words_that_can_be_said() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a.stl", &block(10.0, 12.0, 14.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0).id;
    let backup = farm.write_backup("backup");
    publish(&mut farm, 1);
    fs::remove_file(&farm.queued()[0]).unwrap();
    let again = OperatorWord::Reprint(ReprintTarget::Part(part, Some(1)));
    farm.say(&again, false).unwrap();
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.pass_secs(2.0);
    farm.stop();
    let told = farm.restore(&backup).doubts.join("\n");
    assert!(told.contains("is built") && !told.contains("nestd retry"), "{told}");
    assert!(told.contains(&format!("`nestd reprint {part}=N` prints copies of it again")), "{told}");
    farm.start();
    farm.say(&again, false).unwrap();
    farm.wait_for_parts(PartState::Waiting, 1);
    publish(&mut farm, 1);
}

/// Records an order of two lines as the door does, and its note.
fn take_order(farm: &HandDrivenFarm) -> NewOrderRequest {
    let bytes = stl(&block(10.0, 12.0, 14.0));
    let contents = PutContents::of_farm(&farm.root().join("state"));
    contents.create_folder().unwrap();
    let content_hash = blake3::hash(&bytes).to_hex().to_string();
    fs::write(contents.path_of(&content_hash), bytes).unwrap();
    let line = |at: usize| OrderedLine {
        claim: ordered_claim_id("mes", "k1", "f", at),
        client: "mes".to_owned(),
        machine: MACHINE.to_owned(),
        order_name: "K-1".to_owned(),
        name: format!("line{at}.stl"),
        content_hash: content_hash.clone(),
        copies: 2,
        ticket: r#"{"copies":2,"order":"K-1"}"#.to_owned(),
        read_unit: None,
    };
    let answered = AnsweredRequest { fingerprint: "f".to_owned(), answer: "{}".to_owned() };
    let (client, key) = ("mes".to_owned(), "k1".to_owned());
    let order = NewOrderRequest { client, key, answered, lines: vec![line(1), line(2)] };
    farm.ask(async |ledger| {
        ledger.record_order_request(&order).await.unwrap();
        note_order(ledger, &farm.root().join("state"), "mes", "k1", &order.answered).await.unwrap();
    });
    order
}

#[test]
fn an_order_that_was_answered_is_taken_in_by_a_restore_whatever_became_of_its_lines_since() {
    // Whether a line is cancelled and the others become parts before the ledger is put back.
    for (is_cancelled, is_taken) in [(false, false), (true, false), (false, true)] {
        let mut farm = HandDrivenFarm::open(QUICK);
        let backup = farm.write_backup("backup");
        let order = take_order(&farm);
        let state = farm.root().join("state");
        if is_cancelled {
            farm.ask(async |ledger| {
                assert!(ledger.cancel_arriving_line(&order.lines[0], "by ann").await.unwrap());
                update_order_notes(ledger, &state).await.unwrap();
            });
        }
        if is_taken {
            farm.wait_for_parts(PartState::Waiting, 2);
        }
        farm.stop();
        let told = farm.restore(&backup).done.join("\n");
        assert_eq!(told.contains("line1.stl of order K-1"), !is_cancelled && !is_taken, "{told}");
        assert_eq!(told.contains("line2.stl of order K-1"), !is_taken, "{told}");
        farm.start();
        let parts = if is_cancelled { 1 } else { 2 };
        farm.wait_for_parts(PartState::Waiting, parts);
        publish(&mut farm, 1);
        assert_eq!(farm.parts(PartState::Built).len(), parts);
        farm.assert_nothing_lost_or_doubled();
        farm.ask(async |ledger| update_order_notes(ledger, &state).await.unwrap());
        assert_eq!(fs::read_dir(state.join("put/orders")).unwrap().count(), 0, "its lines are parts");
    }
}

#[test]
fn a_build_that_was_published_after_the_backup_was_made_is_known_to_be_it_and_needs_no_second_yes() {
    let mut farm = HandDrivenFarm::open(&format!("approve = \"always\"\n{QUICK}"));
    farm.drop_part("a.stl", &block(10.0, 12.0, 14.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.order(CommandKind::Flush, None);
    let proved =
        |farm: &HandDrivenFarm| farm.ask(async |ledger| ledger.builds_in_state(BuildState::Verified).await.unwrap());
    farm.pass_until("the build is proved", |farm| proved(farm).len() == 1);
    let (build, backup) = (proved(&farm).remove(0), farm.write_backup("backup"));
    farm.say(&OperatorWord::Release { build: build.id, seen: None }, false).unwrap();
    let queued = farm.wait_for_queued(1);
    farm.wait_for_parts(PartState::Built, 1);
    farm.pass_secs(2.0);
    fs::remove_file(&queued[0]).unwrap();
    farm.stop();
    let report = farm.restore(&backup);
    assert!(report.done.iter().any(|done| done.contains("was published since")), "{report:?}");
    farm.start();
    assert_eq!(farm.violations(), [""; 0], "the restored ledger holds together with the folders");
    farm.pass_secs(2.0);
    assert_eq!(farm.parts(PartState::Built).len(), 1);
    assert!(farm.queued().is_empty() && proved(&farm).is_empty(), "nothing is printed again or waits for a yes");
}

#[test]
fn copies_that_were_told_bad_and_printed_again_after_the_backup_was_made_are_not_printed_a_third_time() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a.stl", &block(10.0, 12.0, 14.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    let printed = |farm: &mut HandDrivenFarm| {
        publish(farm, 1);
        fs::remove_file(&farm.queued()[0]).unwrap();
        farm.pass_secs(2.0);
    };
    printed(&mut farm);
    let first = farm.ask(async |ledger| ledger.builds_in_state(BuildState::Published).await.unwrap()).remove(0).id;
    let backup = farm.write_backup("backup");
    let failed = OperatorWord::Outcome(first, ToldOutcome::new(PrintOutcome::Failed, "", "ann@farm"));
    farm.say(&failed, false).unwrap();
    printed(&mut farm);
    farm.stop();
    let report = farm.restore(&backup);
    assert!(report.doubts.iter().any(|doubt| doubt.contains("as bad: build")), "{report:?}");
    farm.start();
    farm.pass_secs(2.0);
    // As the documents say: the outcomes are recorded again.
    farm.say(&failed, false).unwrap();
    farm.pass_secs(5.0);
    assert_eq!(farm.parts(PartState::Built).len(), 1, "{:?}", farm.parts(PartState::Waiting));
    assert!(farm.queued().is_empty(), "it is not printed a third time");
    assert_eq!(farm.violations(), [""; 0]);
}

/// What a revision has taken over stands in the ledger alone, and in the note of its claim.
#[test]
fn what_a_revision_took_over_after_the_backup_was_made_is_asked_for_after_a_restore() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_bytes("kit/a.stl.toml", b"copies = 3\nunit = \"inch\"\npriority = 90\ncustomer = \"Brandt\"\n");
    farm.drop_part("kit/a.stl", &block(0.4, 0.4, 0.5));
    farm.wait_for_parts(PartState::Waiting, 1);
    let backup = farm.write_backup("backup");
    farm.drop_part("kit/a.stl", &block(0.4, 0.4, 0.6));
    farm.pass_until("the first is out", |farm| farm.parts(PartState::Refused).len() == 1);
    farm.pass_secs(2.0);
    farm.stop();
    farm.restore(&backup);
    farm.start();
    farm.pass_until("it is taken in", |farm| {
        farm.parts(PartState::Waiting).iter().any(|part| part.file.content_hash == hash_of(&block(0.4, 0.4, 0.6)))
    });
    let parts = farm.parts(PartState::Waiting);
    let part = parts.iter().find(|part| part.file.content_hash == hash_of(&block(0.4, 0.4, 0.6))).unwrap();
    assert_eq!((part.owed.copies, part.terms.priority, part.terms.customer.as_str()), (3, 90, "Brandt"));
    assert!((part.measures.size_z_mm.unwrap() - 15.24).abs() < 1e-3, "{:?}", part.size_mm());
}

fn hash_of(mesh: &solids::Mesh) -> String {
    blake3::hash(&stl(mesh)).to_hex().to_string()
}

/// A part is printed again in the size in which it was asked for last, or nobody prints it.
#[test]
fn a_unit_that_was_changed_after_the_backup_was_made_holds_after_a_restore() {
    for is_printed in [true, false] {
        let mut farm = HandDrivenFarm::open(QUICK);
        farm.drop_bytes("a.stl.toml", b"unit = \"inch\"\n");
        farm.drop_part("a.stl", &block(0.4, 0.4, 0.5));
        let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0).id;
        let backup = farm.write_backup("backup");
        let edit = PartEdit { unit: Some(build_file::LengthUnit::Centimeter), ..PartEdit::default() };
        let argument = CommandArgument { edit: Some(edit), ..CommandArgument::default() };
        change(&mut farm, CommandKind::Edit, part, argument, "");
        farm.pass_until("it is read again", |farm| {
            farm.parts(PartState::Waiting).iter().any(|part| part.measures.size_z_mm == Some(5.0))
        });
        if is_printed {
            publish(&mut farm, 1);
            fs::remove_file(&farm.queued()[0]).unwrap();
        }
        farm.pass_secs(2.0);
        farm.stop();
        let told = farm.restore(&backup);
        farm.start();
        farm.pass_secs(2.0);
        if is_printed {
            let build = farm.ask(async |ledger| ledger.builds_in_state(BuildState::Published).await.unwrap())[0].id;
            let failed = OperatorWord::Outcome(build, ToldOutcome::new(PrintOutcome::Failed, "", "ann@farm"));
            farm.say(&failed, false).unwrap();
        } else {
            farm.order_and_wait(CommandKind::Retry, Some(part));
        }
        farm.pass_secs(5.0);
        let row = farm.ask(async |ledger| ledger.find_part(part).await.unwrap().unwrap());
        assert_eq!(row.terms.unit, Some(build_file::LengthUnit::Centimeter), "{is_printed}: {told:?}");
        let is_right = row.measures.size_z_mm == Some(5.0);
        assert!(is_right || !row.owed.question.is_empty(), "{is_printed}: {row:?}\n{told:?}");
    }
}
