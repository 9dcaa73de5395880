//! Just in time: the open build waits for room in the queue, and a published build is taken back out of it unless its printer was
//! first. No copy is printed twice or not at all.

use std::fs;

use delivery::queue::{PrinterQueue, QueueFolder};
use ledger::{
    BuildId, BuildRow, BuildState, CommandArgument, CommandKind, InQueueError, LedgerError, NewCommand, OperatorWord,
    PartEdit, PartState, PrintOutcome, ToldOutcome,
};

use super::printers::{build_part, published};
use crate::{
    AlertKind,
    driven_tests::{HandDrivenFarm, MACHINE, QUICK, block, hand_driven_farm::farm_files::assert_each_copy_once},
};

fn withdraw(farm: &HandDrivenFarm, build: BuildId) -> Result<(), LedgerError> {
    farm.say(&OperatorWord::Withdraw(build, "a mistake".to_owned()), false).map(drop)
}

fn find(farm: &HandDrivenFarm, build: BuildId) -> BuildRow {
    farm.ask(async |ledger| ledger.find_build(build).await.unwrap().unwrap())
}

fn wait_for_end(farm: &mut HandDrivenFarm, build: BuildId) {
    farm.pass_until("the withdrawal has ended", |farm| find(farm, build).place.withdraw_by.is_none());
}

fn open_queue(farm: &HandDrivenFarm) -> QueueFolder {
    QueueFolder::open(farm.folder_of("queue", MACHINE)).unwrap()
}

/// A farm with one published build.
fn one_build(options: &str) -> (HandDrivenFarm, BuildId, String) {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}{options}"));
    build_part(&mut farm, "a.stl", 20.0);
    let build = published(&farm).remove(0);
    (farm, build.id, build.staged.file_name.unwrap())
}

fn flush_again(farm: &mut HandDrivenFarm, queued: usize) {
    // A person's withdrawal paused the machine.
    farm.ask(async |ledger| ledger.resume_machine(MACHINE, "a@test").await.unwrap());
    farm.tick();
    farm.order(CommandKind::Flush, None);
    farm.wait_for_queued(queued);
    farm.pass_until("all of it is built", |farm| farm.parts(PartState::Waiting).is_empty());
}

#[test]
fn while_the_queue_is_full_the_open_build_takes_parts_and_fires_when_the_printer_takes_its_file() {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}queue_depth = 1\n[trigger]\ncopies = 1\n"));
    farm.drop_part("a.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_queued(1);
    for name in ["b.stl", "c.stl"] {
        farm.drop_part(name, &block(20.0, 20.0, 20.0));
        farm.pass_secs(20.0);
    }
    assert_eq!((farm.queued().len(), farm.parts(PartState::Waiting).len(), farm.open_copies().len()), (1, 2, 2));
    let text = farm.status_text();
    assert!(text.contains("The open build waits: the queue is full (queue_depth = 1)"), "{text}");
    assert!(!text.contains("It fires"), "{text}");
    let mut taken = farm.queued();
    let kept = farm.root().join("taken.build.3mf");
    fs::rename(&taken[0], &kept).unwrap();
    taken[0] = kept;
    farm.pass_until("the next build is there", |farm| farm.queued().len() == 1);
    farm.drop_part("d.stl", &block(20.0, 20.0, 20.0));
    farm.pass_secs(20.0);
    assert_eq!((farm.queued().len(), farm.parts(PartState::Waiting).len()), (1, 1));
    // A person's word goes before the rule.
    flush_again(&mut farm, 2);
    assert_each_copy_once(&[taken, farm.queued()].concat(), 4);
    assert_eq!(published(&farm).len(), 3);
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn a_build_that_is_taken_back_can_be_changed_and_comes_again() {
    let (mut farm, build, file) = one_build("");
    withdraw(&farm, build).unwrap();
    wait_for_end(&mut farm, build);
    let waiting = farm.wait_for_parts(PartState::Waiting, 1);
    assert!(farm.queued().is_empty() && !open_queue(&farm).withdrawn_path(&file).exists());
    let row = find(&farm, build);
    assert!(row.place.withdrawn_at.is_some() && row.reason.contains("withdrawn from the queue by ann@farm: a mistake"));
    assert!(farm.ask(async |ledger| ledger.unseen_failures().await.unwrap()).is_empty(), "nobody needs to see to it");
    assert!(matches!(withdraw(&farm, build), Err(LedgerError::WrongState { .. })));
    farm.pass_secs(30.0);
    assert!(farm.queued().is_empty() && farm.status_text().contains("PAUSED by ann@farm"), "it waits for a person");
    let edit = PartEdit { copies: Some(3), ..PartEdit::default() };
    let argument = CommandArgument { edit: Some(edit), ..CommandArgument::default() };
    let command = NewCommand {
        kind: CommandKind::Edit,
        machine: String::new(),
        part: Some(waiting[0].id),
        argument,
        asked_by: "a@test".to_owned(),
    };
    farm.submit_command(&command);
    farm.pass_until("three copies wait", |farm| farm.open_copies().len() == 3);
    flush_again(&mut farm, 1);
    assert_each_copy_once(&farm.queued(), 3);
    let sums = farm.ask(async |ledger| ledger.height_summaries(&Default::default()).await.unwrap());
    assert_eq!((sums[0].builds, sums[0].copies), (1, 3), "what was withdrawn was not printed");
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn no_copy_of_a_build_that_was_taken_back_is_lost_and_its_file_is_told_of_where_somebody_puts_it_back() {
    let (mut farm, build, _) = one_build("");
    let file = farm.queued().remove(0);
    let bytes = fs::read(&file).unwrap();
    withdraw(&farm, build).unwrap();
    wait_for_end(&mut farm, build);
    for outcome in [PrintOutcome::Complete, PrintOutcome::Interrupted] {
        let told = ToldOutcome { is_correction: true, ..ToldOutcome::new(outcome, "", "ann@farm") };
        let refused = farm.say(&OperatorWord::Outcome(build, told), true).unwrap_err();
        assert!(matches!(refused, LedgerError::TakenBack(_)), "{refused}");
    }
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0).id;
    fs::write(&file, bytes).unwrap();
    farm.pass_until("it is told", |farm| farm.has_alert(AlertKind::QueueAltered));
    let told = format!("{} {}", farm.alert_text(AlertKind::QueueAltered), AlertKind::QueueAltered.remedy());
    assert!(told.contains("`nestd cancel PART=N`") && !told.contains("nestd outcome"), "{told}");
    fs::remove_file(&file).unwrap();
    // Somebody printed it all the same: the remedy that alert and refusal name.
    let argument = CommandArgument { copies: Some(1), ..CommandArgument::default() };
    let (kind, machine, asked_by) = (CommandKind::Cancel, String::new(), "a@test".to_owned());
    farm.submit_command(&NewCommand { kind, machine, part: Some(part), argument, asked_by });
    farm.pass_until("no copy waits", |farm| farm.parts(PartState::Waiting).is_empty());
    farm.assert_ledger_agrees_with_folders();
}

fn tell(farm: &HandDrivenFarm, build: BuildId, outcome: PrintOutcome, anyway: bool) -> Result<(), LedgerError> {
    let is_correction = !matches!(find(farm, build).state, BuildState::Published | BuildState::Printing);
    let told = ToldOutcome { is_correction, ..ToldOutcome::new(outcome, "", "ann@farm") };
    farm.say(&OperatorWord::Outcome(build, told), anyway).map(drop)
}

#[test]
fn a_build_that_was_told_failed_while_its_file_lay_untouched_never_counts_as_printed() {
    let (mut farm, build, _) = one_build("");
    let (file, bytes) = (farm.queued().remove(0), fs::read(&farm.queued()[0]).unwrap());
    tell(&farm, build, PrintOutcome::Failed, true).unwrap();
    wait_for_end(&mut farm, build);
    let row = find(&farm, build);
    assert!(row.place.withdrawn_at.is_some() && row.state_word() == "withdrawn", "{row:?}");
    let refused = tell(&farm, build, PrintOutcome::Complete, true);
    assert!(matches!(refused, Err(LedgerError::TakenBack(_))), "{refused:?}");
    farm.wait_for_parts(PartState::Waiting, 1);
    fs::write(&file, bytes).unwrap();
    farm.pass_until("it is told", |farm| farm.alert_text(AlertKind::QueueAltered).contains("withdrawn"));
    fs::remove_file(&file).unwrap();
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn what_people_told_of_a_print_before_its_file_was_taken_out_can_be_corrected_and_the_file_is_told_of_when_it_comes_back()
 {
    for first in [PrintOutcome::Printing, PrintOutcome::Complete] {
        let (mut farm, build, _) = one_build("");
        let (file, bytes) = (farm.queued().remove(0), fs::read(&farm.queued()[0]).unwrap());
        // They leave the files of what they print in the folder.
        tell(&farm, build, first, false).unwrap();
        tell(&farm, build, PrintOutcome::Failed, true).unwrap();
        wait_for_end(&mut farm, build);
        assert_eq!((find(&farm, build).state_word().as_str(), farm.queued().len()), ("failed", 0));
        tell(&farm, build, PrintOutcome::Complete, false).unwrap();
        assert_eq!(farm.parts(PartState::Built).len(), 1, "{first}");
        farm.assert_ledger_agrees_with_folders();
        fs::write(&file, bytes).unwrap();
        farm.pass_until("it is told", |farm| farm.alert_text(AlertKind::QueueAltered).contains("was out of the queue"));
    }
}

#[test]
fn a_build_whose_printer_is_first_stays() {
    let (mut farm, build, _) = one_build("");
    withdraw(&farm, build).unwrap();
    fs::remove_file(&farm.queued()[0]).unwrap();
    wait_for_end(&mut farm, build);
    let row = find(&farm, build);
    assert_eq!((row.state, row.place.withdrawn_at), (BuildState::Published, None));
    assert!(row.place.taken_at.is_some() && farm.parts(PartState::Built).len() == 1);
    assert!(matches!(withdraw(&farm, build), Err(LedgerError::NotInQueue(_))));
    farm.assert_ledger_agrees_with_folders();
}

/// What a daemon did of a withdrawal before it was killed.
#[derive(Debug, Clone, Copy, PartialEq)]
enum DoneBeforeKill {
    Nothing,
    Renamed,
    PutBack,
    Removed,
}

#[test]
fn a_withdrawal_goes_on_wherever_the_daemon_was_killed_and_nothing_else_is_told_meanwhile() {
    let kills = [DoneBeforeKill::Nothing, DoneBeforeKill::Renamed, DoneBeforeKill::PutBack, DoneBeforeKill::Removed];
    for (kill, tell) in kills.into_iter().flat_map(|kill| [(kill, false), (kill, true)]) {
        let (mut farm, build, file) = one_build("");
        withdraw(&farm, build).unwrap();
        let queue = open_queue(&farm);
        if kill != DoneBeforeKill::Nothing {
            queue.take_back(&file, &|_| Ok(true)).unwrap();
        }
        if tell {
            let failed = OperatorWord::Outcome(build, ToldOutcome::new(PrintOutcome::Failed, "", "b@test"));
            let refused = farm.say(&failed, true);
            assert!(matches!(refused, Err(LedgerError::InQueue(InQueueError::BeingTakenBack(_)))), "{refused:?}");
        }
        if matches!(kill, DoneBeforeKill::PutBack | DoneBeforeKill::Removed) {
            assert!(farm.ask(async |ledger| ledger.finish_noted_word(build, true).await.unwrap()).is_some());
        }
        if kill == DoneBeforeKill::Removed {
            queue.remove_taken_back(&file).unwrap();
        }
        farm.stop();
        farm.start();
        wait_for_end(&mut farm, build);
        assert!(!queue.withdrawn_path(&file).exists(), "{kill:?}, told: {tell}");
        farm.wait_for_parts(PartState::Waiting, 1);
        flush_again(&mut farm, 1);
        assert_each_copy_once(&farm.queued(), 1);
        farm.assert_ledger_agrees_with_folders();
    }
}

#[test]
fn what_is_urgent_has_the_build_in_the_queue_taken_back_and_goes_with_it() {
    let (mut farm, build, _) = one_build("withdraw = \"urgent\"\nqueue_depth = 1\n");
    farm.drop_part("usual.stl", &block(20.0, 20.0, 20.0));
    farm.pass_secs(30.0);
    assert_eq!(find(&farm, build).state, BuildState::Published, "nothing is urgent");
    fs::write(farm.folder("inbox").join("urgent.stl.toml"), "priority = 100\n").unwrap();
    farm.drop_part("urgent.stl", &block(20.0, 20.0, 20.0));
    farm.pass_until("the build is taken back", |farm| find(farm, build).place.withdrawn_at.is_some());
    farm.pass_until("all go together", |farm| farm.parts(PartState::Built).len() == 3);
    assert_each_copy_once(&farm.queued(), 3);
    let now = published(&farm);
    assert_eq!((now.len(), now[0].fired_by.as_str()), (1, "withdrawn"));
    farm.pass_secs(30.0);
    assert_eq!(published(&farm), now, "it is not taken back again");
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn what_is_urgent_takes_one_build_back_and_goes_before_its_copies() {
    let options = "withdraw = \"urgent\"\nwall_margin_mm = 0\norientation = \"fixed\"\n";
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}{options}"));
    // Each of these fills the volume.
    for name in ["a.stl", "b.stl"] {
        farm.drop_part(name, &block(118.0, 118.0, 118.0));
        farm.wait_for_parts(PartState::Waiting, 1);
        farm.order(CommandKind::Flush, None);
        farm.pass_until("it is in the queue", |farm| farm.parts(PartState::Waiting).is_empty());
    }
    farm.wait_for_queued(2);
    let [older, newer] = published(&farm).try_into().unwrap();
    fs::write(farm.folder("inbox").join("u.stl.toml"), "priority = 100\n").unwrap();
    farm.drop_part("u.stl", &block(118.0, 118.0, 118.0));
    farm.pass_until("the newer build is taken back", |farm| find(farm, newer.id).place.withdrawn_at.is_some());
    farm.pass_until("the urgent part is in the queue", |farm| {
        farm.parts(PartState::Built).iter().any(|part| part.name == "u.stl")
    });
    farm.pass_secs(60.0);
    let waiting: Vec<String> = farm.parts(PartState::Waiting).into_iter().map(|part| part.name).collect();
    assert_eq!((find(&farm, older.id).state, waiting), (BuildState::Published, vec!["b.stl".to_owned()]));
    flush_again(&mut farm, 3);
    assert_each_copy_once(&farm.queued(), 3);
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn while_the_printer_prints_for_long_a_published_build_takes_what_arrives() {
    let options = "withdraw = \"always\"\nprint_hours_per_mm = 1.0\n[trigger]\ngather_secs = \"30s\"\n";
    let (mut farm, first, _) = one_build(options);
    fs::remove_file(&farm.queued()[0]).unwrap();
    farm.pass_until("it is printed", |farm| find(farm, first).place.taken_at.is_some());
    build_part(&mut farm, "b.stl", 20.0);
    let second = published(&farm).pop().unwrap().id;
    farm.drop_part("c.stl", &block(20.0, 20.0, 20.0));
    farm.pass_until("the second build takes it", |farm| farm.parts(PartState::Built).len() == 3);
    assert_eq!(find(&farm, second).state, BuildState::Failed);
    assert_each_copy_once(&farm.queued(), 2);
    assert_eq!(find(&farm, first).state, BuildState::Published);
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn a_ledger_from_before_a_withdrawal_prints_nothing_twice_and_tells_of_it() {
    let (mut farm, build, _) = one_build("");
    let backup = farm.write_backup("before.db");
    withdraw(&farm, build).unwrap();
    wait_for_end(&mut farm, build);
    farm.wait_for_parts(PartState::Waiting, 1);
    flush_again(&mut farm, 1);
    farm.stop();
    let restored = farm.restore(&backup);
    let is_told = |said: &String| said.contains("taken back out of the queue untouched since");
    assert!(restored.done.iter().any(is_told), "{restored:?}");
    farm.start();
    farm.pass_secs(60.0);
    assert_each_copy_once(&farm.queued(), 1);
    assert!(farm.parts(PartState::Waiting).is_empty(), "nothing is printed again without a person's word");
}
