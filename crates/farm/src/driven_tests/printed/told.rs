//! What people say of builds whose files still lie in their queue: no printer could ever print more copies than are wanted.

use std::fs;

use ledger::{
    BuildId, BuildRow, BuildState, CommandKind, EventKind, InQueueError, LedgerError, OperatorWord, PartState,
    PickMark, PrintOutcome, ReprintTarget, ToldOutcome,
};

use super::printers::{published, queue, two_printers};
use crate::{
    AlertKind,
    driven_tests::{
        HandDrivenFarm, MACHINE, QUICK, block,
        hand_driven_farm::farm_files::{assert_each_copy_once, list_build_files},
    },
};

/// A farm with one published build of three copies.
fn three_copies() -> (HandDrivenFarm, BuildRow) {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_bytes("a.stl.toml", b"copies = 3\n");
    farm.drop_part("a.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.order(CommandKind::Flush, None);
    farm.wait_for_parts(PartState::Built, 1);
    let build = published(&farm).remove(0);
    (farm, build)
}

fn outcome(build: &BuildRow, outcome: PrintOutcome, bad: u32) -> OperatorWord {
    let part = ledger::PartId(1);
    let bad = if bad > 0 { vec![(part, bad)] } else { Vec::new() };
    OperatorWord::Outcome(build.id, ToldOutcome { bad, ..ToldOutcome::new(outcome, "", "ann@farm") })
}

fn find(farm: &HandDrivenFarm, build: BuildId) -> BuildRow {
    farm.ask(async |ledger| ledger.find_build(build).await.unwrap().unwrap())
}

/// Every word that makes copies bad, and how many.
fn words(farm: &HandDrivenFarm, build: &BuildRow) -> Vec<(OperatorWord, usize)> {
    let marks: Vec<_> = (0..3).map(|copy| (ledger::PartId(1), copy)).collect();
    farm.ask(async |ledger| ledger.mark_picks(build.id, &marks, PickMark::Missing, "ann@farm").await.unwrap());
    vec![
        (outcome(build, PrintOutcome::Failed, 0), 3),
        (outcome(build, PrintOutcome::Complete, 1), 1),
        (outcome(build, PrintOutcome::Interrupted, 2), 2),
        (OperatorWord::BreakOut(build.id), 3),
        (OperatorWord::Reprint(ReprintTarget::Build(build.id)), 3),
        (OperatorWord::Requeue(build.id), 3),
    ]
}

#[test]
fn a_word_that_has_copies_printed_again_takes_the_file_out_of_the_queue_first_or_is_refused() {
    for number in 0..6 {
        let (mut farm, build) = three_copies();
        let (word, again) = words(&farm, &build).swap_remove(number);
        let refused = farm.say(&word, false).unwrap_err();
        assert!(refused.to_string().contains("lies untouched in the queue"), "{refused}");
        assert_eq!((find(&farm, build.id), farm.queued().len()), (build.clone(), 1), "{word:?}");
        let noted = farm.say(&word, true).unwrap();
        assert_eq!(noted.noted, [build.id]);
        assert!(farm.parts(PartState::Waiting).is_empty(), "no copy waits before the file is back: {word:?}");
        let twice = farm.say(&word, true);
        assert!(matches!(twice, Err(LedgerError::InQueue(InQueueError::BeingTakenBack(_)))), "{twice:?}");
        // Wherever the daemon is killed, it goes on.
        if number % 2 == 0 {
            farm.stop();
            farm.start();
        }
        farm.pass_until("the word is carried out", |farm| find(farm, build.id).place.withdraw_by.is_none());
        let events = farm.ask(async |ledger| ledger.events_of_build(build.id).await.unwrap());
        let at = |kind: EventKind| events.iter().position(|event| event.kind == kind);
        assert_eq!(at(EventKind::Printing).is_some(), matches!(number, 1..=3), "nobody printed it: {events:?}");
        let ended =
            [EventKind::Failed, EventKind::Complete, EventKind::Interrupted].map(at).into_iter().flatten().min();
        assert!(number > 3 || at(EventKind::Withdrawn) < ended, "it was out of the queue before: {events:?}");
        farm.order(CommandKind::Flush, None);
        farm.wait_for_queued(1);
        assert_each_copy_once(&farm.queued(), again);
        farm.assert_ledger_agrees_with_folders();
    }
}

#[test]
fn a_word_is_carried_out_at_once_where_the_file_was_taken_or_no_copy_is_bad() {
    for number in 0..6 {
        let (mut farm, build) = three_copies();
        let (word, again) = words(&farm, &build).swap_remove(number);
        let taken = farm.root().join("taken.build.3mf");
        fs::rename(&farm.queued()[0], &taken).unwrap();
        assert!(farm.say(&word, false).unwrap().noted.is_empty(), "{word:?}");
        farm.pass_secs(2.0);
        farm.order(CommandKind::Flush, None);
        farm.wait_for_queued(1);
        assert_each_copy_once(&farm.queued(), again);
        farm.assert_ledger_agrees_with_folders();
    }
    let (farm, build) = three_copies();
    assert!(farm.say(&outcome(&build, PrintOutcome::Complete, 0), false).unwrap().noted.is_empty());
    // It stays in the folder for months; then somebody corrects what was told.
    let mut failed = ToldOutcome::new(PrintOutcome::Failed, "", "ann@farm");
    failed.is_correction = true;
    let word = OperatorWord::Outcome(build.id, failed);
    assert!(farm.say(&word, false).is_err() && farm.say(&word, true).is_ok());
}

#[test]
fn some_copies_of_a_build_that_nobody_told_of_are_not_printed_again_while_its_file_lies_there() {
    let (farm, build) = three_copies();
    let word = OperatorWord::Reprint(ReprintTarget::Part(ledger::PartId(1), Some(1)));
    for anyway in [false, true] {
        let refused = farm.say(&word, anyway).unwrap_err();
        assert!(matches!(refused, LedgerError::InQueue(InQueueError::NotTold { .. })), "{refused}");
    }
    assert_eq!(find(&farm, build.id), build);
}

#[test]
fn a_file_that_was_emptied_replaced_or_is_a_folder_is_not_taken_back() {
    for harm in ["emptied", "replaced", "folder"] {
        let (mut farm, build) = three_copies();
        let file = farm.queued().remove(0);
        let proved = fs::read(&file).unwrap();
        let (withdraw, failed) =
            (OperatorWord::Withdraw(build.id, String::new()), outcome(&build, PrintOutcome::Failed, 0));
        for word in [&withdraw, &failed] {
            if file.is_dir() {
                fs::remove_dir(&file).unwrap()
            } else {
                fs::remove_file(&file).unwrap()
            }
            fs::write(&file, &proved).unwrap();
            farm.say(word, true).unwrap();
            fs::remove_file(&file).unwrap();
            match harm {
                "folder" => fs::create_dir(&file).unwrap(),
                _ => fs::write(&file, vec![7; if harm == "emptied" { 0 } else { proved.len() }]).unwrap(),
            }
            farm.pass_until("it is told", |farm| farm.has_alert(AlertKind::QueueAltered));
            farm.pass_until("the word is dropped", |farm| find(farm, build.id).place.withdraw_by.is_none());
            farm.pass_secs(3.0);
            assert_eq!(
                farm.has_alert(AlertKind::NotTakenBack),
                *word == failed,
                "who withdraws it only wants the file"
            );
        }
        let told = farm.alert_text(AlertKind::NotTakenBack);
        assert!(told.contains("is not the file that was proved") && told.contains("once more"), "{harm}: {told}");
        // Said of what is altered already, it is refused at once, and nobody is asked to insist.
        for (word, anyway) in [(&withdraw, false), (&failed, false), (&failed, true)] {
            let refused = farm.say(word, anyway).unwrap_err();
            assert!(matches!(refused, LedgerError::InQueue(InQueueError::Altered { .. })), "{harm}: {refused}");
        }
        let row = find(&farm, build.id);
        assert_eq!((row.state, row.place.withdrawn_at), (BuildState::Published, None), "{harm}");
        assert!(file.exists() && farm.parts(PartState::Waiting).is_empty(), "{harm}");
        // The remedy that is named.
        if harm == "folder" {
            fs::remove_dir(&file).unwrap()
        } else {
            fs::remove_file(&file).unwrap()
        }
        farm.say(&outcome(&build, PrintOutcome::Failed, 0), false).unwrap();
        farm.pass_until("it is over", |farm| {
            !farm.has_alert(AlertKind::NotTakenBack) && !farm.has_alert(AlertKind::QueueAltered)
        });
        farm.wait_for_parts(PartState::Waiting, 1);
    }
}

#[test]
fn who_says_that_a_build_is_printed_whose_file_lies_untouched_is_told_that_it_lies_there() {
    let (farm, build) = three_copies();
    let said = farm.say(&outcome(&build, PrintOutcome::Complete, 0), false).unwrap().sentences.join(" ");
    let lies = format!("lies untouched in the queue of {MACHINE}: take it out");
    assert!(said.contains("complete") && said.contains(&lies), "{said}");
    assert_eq!(farm.queued().len(), 1, "a printer may have made itself a copy of it");

    let (farm, build) = three_copies();
    fs::remove_file(farm.queued().remove(0)).unwrap();
    let said = farm.say(&outcome(&build, PrintOutcome::Complete, 0), false).unwrap().sentences.join(" ");
    assert!(said.contains("complete") && !said.contains("untouched"), "{said}");
}

#[test]
fn a_file_that_comes_back_lies_in_the_queue_again() {
    let (mut farm, build) = three_copies();
    let (file, aside) = (farm.queued().remove(0), farm.root().join("aside"));
    fs::rename(&file, &aside).unwrap();
    farm.pass_until("it is gone", |farm| find(farm, build.id).place.taken_at.is_some());
    fs::rename(&aside, &file).unwrap();
    let failed = outcome(&build, PrintOutcome::Failed, 0);
    assert!(matches!(farm.say(&failed, false), Err(LedgerError::InQueue(InQueueError::LiesThere { .. }))));
    assert_eq!(find(&farm, build.id).place.taken_at, None);
    assert_eq!(farm.folder_of("queue", MACHINE), file.parent().unwrap());
}

#[test]
fn a_published_file_that_was_emptied_or_copied_is_an_alert_until_it_is_as_it_was() {
    let (mut farm, build) = three_copies();
    let file = farm.queued().remove(0);
    let bytes = fs::read(&file).unwrap();
    let copy = file.with_file_name("Copy of it.build.3mf");
    farm.pass_secs(5.0);
    assert!(!farm.has_alert(AlertKind::QueueAltered));
    for harm in ["emptied", "copied"] {
        if harm == "emptied" {
            fs::write(&file, b"").unwrap()
        } else {
            fs::write(&copy, &bytes).unwrap()
        }
        farm.pass_until("it is told", |farm| farm.has_alert(AlertKind::QueueAltered));
        if harm == "emptied" {
            fs::write(&file, &bytes).unwrap()
        } else {
            fs::remove_file(&copy).unwrap();
            farm.say(&OperatorWord::SeenTo(build.id), false).unwrap();
        }
        farm.pass_until("it is over", |farm| !farm.has_alert(AlertKind::QueueAltered));
    }
}

#[test]
fn a_word_about_a_file_that_its_printer_takes_before_it_is_taken_out_changes_nothing_and_is_told() {
    for number in 0..6 {
        let (mut farm, build) = three_copies();
        let (word, _) = words(&farm, &build).swap_remove(number);
        assert_eq!(farm.say(&word, true).unwrap().noted, [build.id]);
        fs::remove_file(&farm.queued()[0]).unwrap();
        farm.pass_until("the word is dropped", |farm| find(farm, build.id).place.withdraw_by.is_none());
        farm.pass_until("that is told", |farm| farm.has_alert(AlertKind::NotTakenBack));
        assert_eq!(find(&farm, build.id).state, BuildState::Published, "{word:?}");
        assert!(farm.parts(PartState::Waiting).is_empty(), "what the printer has is not printed again: {word:?}");
        let told = farm.alert_text(AlertKind::NotTakenBack);
        assert!(told.contains("its printer took it first"), "{told}");
        assert!(!farm.has_alert(AlertKind::PublishingFails), "{told}");
        farm.assert_ledger_agrees_with_folders();
        farm.stop();
        farm.start();
        farm.pass_secs(5.0);
        assert_eq!(farm.alert_text(AlertKind::NotTakenBack), told, "until somebody has looked");
        farm.say(&outcome(&build, PrintOutcome::Complete, 0), true).unwrap();
        farm.pass_until("it is over", |farm| !farm.has_alert(AlertKind::NotTakenBack));
    }
}

#[test]
fn a_word_is_refused_while_the_file_lies_in_the_queue_under_another_name_which_an_alert_names() {
    let names = ["hans.build.3mf", "job.3mf", "JOB.3MF", "job"];
    for (number, is_moved) in (0..6).flat_map(|number| [(number, true), (number, false)]) {
        let (mut farm, build) = three_copies();
        let (word, _) = words(&farm, &build).swap_remove(number);
        let name = names[number % names.len()];
        let (file, other) = (farm.queued().remove(0), farm.folder("queue").join(name));
        fs::copy(&file, &other).unwrap();
        if is_moved {
            fs::remove_file(&file).unwrap();
        }
        for anyway in [false, true] {
            let refused = farm.say(&word, anyway).unwrap_err().to_string();
            let how = if is_moved { "under another name, as" } else { "in the queue of test, and a second time as" };
            assert!(refused.contains(&format!("{how} {name} at test")), "{word:?}: {refused}");
            assert!(refused.contains(&format!("Take {name} at test out")), "{word:?}: {refused}");
            // Its own name is free only where its file does not lie there.
            assert_eq!(refused.contains("its own name back"), is_moved, "{refused}");
        }
        assert_eq!(find(&farm, build.id).state, BuildState::Published);
        farm.pass_until("it is told", |farm| farm.alert_text(AlertKind::QueueAltered).contains(name));
        let told = farm.alert_text(AlertKind::QueueAltered);
        assert_eq!(told.contains("that name back"), is_moved, "{told}");
        fs::remove_file(&other).unwrap();
        farm.say(&word, true).unwrap();
        farm.pass_until("it is over", |farm| !farm.has_alert(AlertKind::QueueAltered));
    }
}

#[test]
fn a_word_is_refused_while_a_second_file_of_the_build_lies_at_another_printer_under_whatever_name() {
    for (number, is_own_name) in (0..7).flat_map(|number| [(number, true), (number, false)]) {
        let mut farm = two_printers("");
        farm.drop_bytes("a.stl.toml", b"copies = 3\n");
        farm.drop_part("a.stl", &block(20.0, 20.0, 20.0));
        farm.wait_for_parts(PartState::Waiting, 1);
        farm.order(CommandKind::Flush, None);
        farm.wait_for_parts(PartState::Built, 1);
        let build = published(&farm).remove(0);
        let withdraw = (OperatorWord::Withdraw(build.id, String::new()), 3);
        let (word, again) = words(&farm, &build).into_iter().chain([withdraw]).nth(number).unwrap();
        let at = build.place.printer.clone().unwrap();
        let other = if at == "left" { "right" } else { "left" };
        let name = build.staged.file_name.clone().unwrap();
        let second = queue(&farm, other).join(if is_own_name { &name } else { "job.3mf" });
        fs::copy(queue(&farm, &at).join(&name), &second).unwrap();
        let seen = second.file_name().unwrap().to_str().unwrap().to_owned();
        for anyway in [false, true] {
            let refused = farm.say(&word, anyway).unwrap_err().to_string();
            let both = format!("in the queue of {at}, and a second time as {seen} at {other}");
            assert!(refused.contains(&both), "{word:?}: {refused}");
            assert!(refused.contains(&format!("Take {seen} at {other} out")), "{word:?}: {refused}");
        }
        farm.pass_secs(5.0);
        assert_eq!((find(&farm, build.id).state, farm.parts(PartState::Waiting).len()), (BuildState::Published, 0));
        fs::remove_file(&second).unwrap();
        farm.say(&word, true).unwrap();
        farm.pass_until("the word is carried out", |farm| find(farm, build.id).place.withdraw_by.is_none());
        farm.order_and_wait(CommandKind::Resume, None);
        farm.order(CommandKind::Flush, None);
        farm.pass_until("its copies are printed", |farm| published(farm).iter().any(|other| other.id != build.id));
        let queued = ["left", "right"].map(|printer| list_build_files(&queue(&farm, printer)));
        assert_each_copy_once(&queued.concat(), again);
    }
}

#[test]
fn a_word_that_was_noted_is_dropped_where_the_file_is_copied_or_renamed_before_it_is_taken_out() {
    for (number, is_moved) in [(0, true), (0, false), (5, true), (6, true), (6, false)] {
        let (mut farm, build) = three_copies();
        let withdraw = (OperatorWord::Withdraw(build.id, String::new()), 3);
        let (word, _) = words(&farm, &build).into_iter().chain([withdraw]).nth(number).unwrap();
        farm.say(&word, true).unwrap();
        farm.stop();
        let (file, other) = (farm.queued().remove(0), farm.folder("queue").join("job.3mf"));
        fs::copy(&file, &other).unwrap();
        if is_moved {
            fs::remove_file(&file).unwrap();
        }
        farm.start();
        farm.pass_until("the word is dropped", |farm| find(farm, build.id).place.withdraw_by.is_none());
        farm.pass_until("the file is told", |farm| farm.alert_text(AlertKind::QueueAltered).contains("job.3mf"));
        farm.pass_secs(3.0);
        assert_eq!(farm.has_alert(AlertKind::NotTakenBack), number < 6, "who withdraws it only wants the file");
        let told = farm.alert_text(AlertKind::NotTakenBack);
        assert!(number == 6 || told.contains("job.3mf at test") && !told.contains("printer took it"), "{told}");
        assert_eq!(find(&farm, build.id).state, BuildState::Published, "{word:?}");
        let detail = farm.ask(async |ledger| ledger.events_of_build(build.id).await.unwrap()).pop().unwrap().detail;
        assert!(number < 6 || detail.contains("job.3mf at test"), "{detail}");
        assert_eq!(file.exists(), !is_moved, "it stays where it is");
        fs::remove_file(&other).unwrap();
        assert_eq!(farm.say(&word, true).is_err(), number == 6 && is_moved, "what is not there is not withdrawn");
        farm.pass_until("it is over", |farm| {
            !farm.has_alert(AlertKind::NotTakenBack) && !farm.has_alert(AlertKind::QueueAltered)
        });
    }
}
