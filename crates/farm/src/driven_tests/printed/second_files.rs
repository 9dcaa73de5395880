//! A person has copied the file of a published build: nestd puts it into no queue again, and says so until somebody has looked.

use std::{fs, path::PathBuf};

use delivery::queue::{PrinterQueue, QueueFolder};
use ledger::{
    BuildRow, BuildState, CommandKind, EventKind, InQueueError, LedgerError, OperatorWord, PartState, PrintOutcome,
    ToldOutcome,
};

use super::printers::{bring_up, build_part, published, queue, take_down, two_printers, visible};
use crate::{
    AlertKind,
    driven_tests::{HandDrivenFarm, block},
};

/// A build that is published on the left, and the path of its file there and of one of that name on the right.
struct Copied {
    farm: HandDrivenFarm,
    build: BuildRow,
    name: String,
    left: PathBuf,
    right: PathBuf,
}

impl Copied {
    fn new() -> Self {
        let mut farm = two_printers("");
        build_part(&mut farm, "a.stl", 20.0);
        let build = published(&farm).remove(0);
        let name = build.staged.file_name.clone().unwrap();
        let [left, right] = ["left", "right"].map(|printer| queue(&farm, printer).join(&name));
        Self { farm, build, name, left, right }
    }

    fn copy_to_the_right(&self) {
        fs::copy(&self.left, &self.right).unwrap();
    }

    fn row(&self) -> BuildRow {
        let id = self.build.id;
        self.farm.ask(async |ledger| ledger.find_build(id).await.unwrap().unwrap())
    }

    fn told(&self) -> String {
        self.farm.alert_text(AlertKind::QueueAltered)
    }

    fn expect_told(&mut self, text: &str) {
        self.farm.pass_until(text, |farm| farm.alert_text(AlertKind::QueueAltered).contains(text));
        assert!(
            !self.farm.has_alert(AlertKind::PublishingFails),
            "{}",
            self.farm.alert_text(AlertKind::PublishingFails)
        );
    }

    fn expect_over(&mut self) {
        self.farm.pass_until("it is over", |farm| !farm.has_alert(AlertKind::QueueAltered));
    }

    fn dismiss(&self) {
        self.farm.say(&OperatorWord::SeenTo(self.build.id), false).unwrap();
    }

    fn relocations(&self) -> Vec<String> {
        let id = self.build.id;
        let events = self.farm.ask(async |ledger| ledger.events_of_build(id).await.unwrap());
        events.into_iter().filter(|event| event.kind == EventKind::Relocated).map(|event| event.detail).collect()
    }

    /// Nothing is left that nestd wrote into the queue folder of a printer.
    fn assert_no_dot_files(&self, printer: &str) {
        let names = fs::read_dir(queue(&self.farm, printer)).unwrap().map(|entry| entry.unwrap().file_name());
        let names: Vec<String> = names.map(|name| name.into_string().unwrap()).collect();
        assert!(names.iter().all(|name| !name.starts_with('.') || name.starts_with(".nestd-")), "{names:?}");
    }

    /// As after a crash in a move to the right: the file was taken back on the left.
    fn begin_move(&self) {
        let id = self.build.id;
        self.farm.ask(async |ledger| ledger.begin_move(id, "right").await.unwrap());
        let left = QueueFolder::open(queue(&self.farm, "left")).unwrap();
        left.take_back(&self.name, &|_| Ok(true)).unwrap();
    }

    fn failed(&self) -> OperatorWord {
        OperatorWord::Outcome(self.build.id, ToldOutcome::new(PrintOutcome::Failed, "", "ann@farm"))
    }

    fn withdraw(&self) -> OperatorWord {
        OperatorWord::Withdraw(self.build.id, String::new())
    }
}

#[test]
fn a_file_that_a_person_copied_to_the_printer_that_its_build_moves_to_is_the_moved_one() {
    for (is_seen, is_begun) in [(false, false), (true, false), (false, true)] {
        let mut copied = Copied::new();
        copied.copy_to_the_right();
        if is_begun {
            copied.begin_move();
        } else if is_seen {
            copied.expect_told(&format!("is a second file of build {}, which lies at left", copied.build.id));
        }
        take_down(&copied.farm, "left");
        copied.farm.pass_until("it is moved", |farm| published(farm)[0].place.printer.as_deref() == Some("right"));
        assert_eq!(visible(&copied.farm), [0, 1], "seen: {is_seen}, begun: {is_begun}");
        for printer in ["left", "right"] {
            copied.assert_no_dot_files(printer);
        }
        assert_eq!(copied.relocations(), ["from left to right"]);
        copied.farm.pass_secs(5.0);
        assert_eq!(copied.told(), "");
        copied.farm.assert_ledger_agrees_with_folders();
        // The printer takes it: it is put into no queue again.
        fs::remove_file(&copied.right).unwrap();
        copied.farm.pass_secs(30.0);
        assert!(copied.row().place.taken_at.is_some() && visible(&copied.farm) == [0, 0]);
        assert_eq!(copied.told(), "");
        copied.farm.assert_ledger_agrees_with_folders();
    }
}

#[test]
fn a_build_does_not_move_to_a_printer_where_another_file_has_its_name_until_that_is_out() {
    for is_begun in [false, true] {
        let mut copied = Copied::new();
        fs::write(&copied.right, b"another").unwrap();
        if is_begun {
            copied.begin_move();
        }
        take_down(&copied.farm, "left");
        copied.expect_told(&format!("{} at right is a second file of build {}", copied.name, copied.build.id));
        copied.farm.pass_secs(10.0);
        assert!(copied.told().contains("take it out"), "{}", copied.told());
        copied.assert_no_dot_files("right");
        for word in [copied.failed(), copied.withdraw()] {
            let refused = copied.farm.say(&word, true).unwrap_err();
            let is_so = matches!(&refused, LedgerError::InQueue(InQueueError::Copied { others, .. }) if others.concat().contains("at right"));
            assert!(is_so, "{is_begun}: {refused}");
            assert!(refused.to_string().contains("out of the queue; then say it again"), "{refused}");
        }
        assert_eq!((copied.row().state, visible(&copied.farm)[1]), (BuildState::Published, 1));
        // The remedy that is named. Whether it was printed from there, nobody but a person can say.
        fs::remove_file(&copied.right).unwrap();
        copied.expect_told(&format!("`nestd dismiss b{}`", copied.build.id));
        copied.farm.pass_secs(10.0);
        assert_eq!(visible(&copied.farm)[1], 0);
        copied.dismiss();
        copied.expect_over();
        copied.farm.pass_until("it is moved", |farm| visible(farm) == [0, 1]);
        copied.farm.assert_ledger_agrees_with_folders();
    }
}

#[test]
fn a_build_of_which_a_second_file_was_taken_stays_where_it_is_until_a_person_has_looked() {
    for (name, is_printed) in [("", true), ("", false), ("job.3mf", true), ("job.3mf", false)] {
        let mut copied = Copied::new();
        let second = if name.is_empty() { copied.right.clone() } else { copied.right.with_file_name(name) };
        let seen = second.file_name().unwrap().to_str().unwrap().to_owned();
        fs::copy(&copied.left, &second).unwrap();
        copied.expect_told(&format!("{seen} at right"));
        fs::remove_file(&second).unwrap();
        let gone =
            format!("a second file of build {} lay in the queue as {seen} at right, and is gone", copied.build.id);
        copied.expect_told(&gone);
        take_down(&copied.farm, "left");
        copied.farm.pass_secs(20.0);
        copied.farm.stop();
        copied.farm.start();
        copied.expect_told(&gone);
        copied.farm.pass_secs(20.0);
        assert_eq!(visible(&copied.farm), [1, 0], "it is put into no queue");
        if is_printed {
            // The remedy that is named.
            fs::remove_file(&copied.left).unwrap();
            let printing = ToldOutcome::new(PrintOutcome::Printing, "", "ann@farm");
            copied.farm.say(&OperatorWord::Outcome(copied.build.id, printing), false).unwrap();
            copied.expect_over();
            copied.farm.pass_secs(5.0);
            assert_eq!((visible(&copied.farm), copied.row().state), ([0, 0], BuildState::Printing));
        } else {
            copied.dismiss();
            copied.expect_over();
            copied.farm.pass_until("it is moved", |farm| visible(farm) == [0, 1]);
        }
        copied.farm.assert_ledger_agrees_with_folders();
    }
}

#[test]
fn a_second_file_that_is_gone_is_not_forgotten_when_the_own_one_is_moved_away_and_put_back() {
    let mut copied = Copied::new();
    copied.copy_to_the_right();
    copied.expect_told("is a second file of build");
    fs::remove_file(&copied.right).unwrap();
    copied.expect_told("`nestd dismiss b");
    let aside = copied.farm.root().join("aside.3mf");
    fs::rename(&copied.left, &aside).unwrap();
    copied.farm.pass_until("it is taken", |farm| published(farm)[0].place.taken_at.is_some());
    fs::rename(&aside, &copied.left).unwrap();
    copied.farm.pass_until("it is back", |farm| published(farm)[0].place.taken_at.is_none());
    copied.expect_told("`nestd dismiss b");
    let refused = copied.farm.say(&copied.failed(), false).unwrap_err();
    assert!(matches!(refused, LedgerError::InQueue(InQueueError::SecondGone { .. })), "{refused}");
    assert_eq!((copied.row().state, visible(&copied.farm)), (BuildState::Published, [1, 0]));
    copied.dismiss();
    copied.expect_over();
    copied.farm.assert_ledger_agrees_with_folders();
}

#[test]
fn no_word_is_heard_while_the_queue_in_which_a_second_file_was_seen_cannot_be_looked_into() {
    for (is_own_taken, is_printed) in [(false, true), (true, false), (true, true)] {
        let mut copied = Copied::new();
        copied.copy_to_the_right();
        copied.expect_told("is a second file of build");
        if is_own_taken {
            fs::remove_file(&copied.left).unwrap();
            copied.farm.pass_until("it is taken", |farm| published(farm)[0].place.taken_at.is_some());
        }
        let (right, away) = (queue(&copied.farm, "right"), copied.farm.root().join("away"));
        fs::rename(&right, &away).unwrap();
        for anyway in [false, true] {
            let refused = copied.farm.say(&copied.failed(), anyway).unwrap_err();
            assert!(matches!(refused, LedgerError::InQueue(InQueueError::SecondUnseen { .. })), "{refused}");
            assert!(refused.to_string().contains(&format!("{} at right", copied.name)), "{refused}");
        }
        assert_eq!(copied.row().state, BuildState::Published);
        if is_printed {
            fs::rename(&away, &right).unwrap();
            let refused = copied.farm.say(&copied.failed(), false).unwrap_err();
            assert!(matches!(refused, LedgerError::InQueue(InQueueError::Copied { .. })), "{refused}");
        } else {
            // The remedy that is named.
            fs::remove_file(away.join(&copied.name)).unwrap();
            copied.dismiss();
            copied.farm.say(&copied.failed(), false).unwrap();
            assert_eq!(copied.row().state, BuildState::Failed);
        }
    }
}

#[test]
fn a_build_does_not_move_while_its_copies_lie_in_a_queue_under_another_name() {
    let mut copied = Copied::new();
    let second = copied.right.with_file_name("job.3mf");
    fs::copy(&copied.left, &second).unwrap();
    take_down(&copied.farm, "left");
    copied.expect_told("job.3mf at right holds the copies");
    copied.farm.pass_secs(20.0);
    assert!(copied.left.exists() && !copied.right.exists() && copied.told().contains("take it out"));
    let refused = copied.farm.say(&copied.withdraw(), false).unwrap_err();
    assert!(matches!(refused, LedgerError::InQueue(InQueueError::Copied { .. })), "{refused}");
    fs::remove_file(&second).unwrap();
    // It may be printed from there: no word has its copies wait again before a person has looked.
    for word in [copied.withdraw(), copied.failed()] {
        let refused = copied.farm.say(&word, false).unwrap_err();
        assert!(matches!(refused, LedgerError::InQueue(InQueueError::SecondGone { .. })), "{refused}");
        assert!(refused.to_string().contains(&format!("`nestd dismiss b{}`", copied.build.id)), "{refused}");
    }
    copied.dismiss();
    copied.farm.say(&copied.withdraw(), false).unwrap();
    copied.farm.wait_for_parts(PartState::Waiting, 1);
    copied.expect_over();
    copied.farm.assert_ledger_agrees_with_folders();
}

#[test]
fn a_file_that_lay_beside_the_one_that_was_taken_is_a_second_one_and_not_a_moved_one() {
    for is_dismissed in [false, true] {
        let mut copied = Copied::new();
        copied.copy_to_the_right();
        copied.expect_told("is a second file of build");
        fs::remove_file(&copied.left).unwrap();
        copied.farm.pass_until("it is taken", |farm| published(farm)[0].place.taken_at.is_some());
        copied.farm.pass_secs(5.0);
        assert_eq!((copied.row().place.printer.as_deref(), copied.relocations().len()), (Some("left"), 0));
        copied.expect_told("which was taken out of the queue of left");
        let refused = copied.farm.say(&copied.failed(), true).unwrap_err();
        assert!(refused.to_string().contains(&format!("{} at right out of the queue", copied.name)), "{refused}");
        assert!(!refused.to_string().contains("own name back"), "{refused}");
        if is_dismissed {
            // The left one was only moved away: this is its file.
            copied.dismiss();
            copied.expect_over();
            assert_eq!(copied.row().place.printer.as_deref(), Some("right"));
            assert!(copied.row().place.taken_at.is_none() && copied.right.exists());
            copied.farm.assert_ledger_agrees_with_folders();
        } else {
            fs::remove_file(&copied.right).unwrap();
            copied.expect_told("may be printed twice");
            copied.farm.say(&copied.failed(), false).unwrap();
            copied.expect_over();
            copied.farm.wait_for_parts(PartState::Waiting, 1);
        }
    }
}

#[test]
fn a_file_that_is_put_back_while_its_build_moves_is_not_moved_and_is_told() {
    let mut copied = Copied::new();
    let bytes = fs::read(&copied.left).unwrap();
    copied.begin_move();
    fs::write(&copied.left, bytes).unwrap();
    take_down(&copied.farm, "left");
    copied.farm.pass_until("it is moved", |farm| visible(farm)[1] == 1 || farm.has_alert(AlertKind::QueueAltered));
    copied.expect_told(&format!("{} at left is a second file of build", copied.name));
    fs::remove_file(&copied.left).unwrap();
    copied.expect_told("and is gone");
    copied.dismiss();
    copied.farm.pass_until("it is moved", |farm| visible(farm) == [0, 1]);
    copied.expect_over();
    copied.farm.assert_ledger_agrees_with_folders();
}

#[test]
fn a_build_that_comes_back_to_its_own_printer_was_not_moved() {
    let mut copied = Copied::new();
    copied.begin_move();
    take_down(&copied.farm, "left");
    take_down(&copied.farm, "right");
    copied.farm.pass_secs(3.0);
    bring_up(&copied.farm, "left");
    copied.farm.pass_until("it is back", |farm| visible(farm) == [1, 0]);
    copied.farm.pass_secs(3.0);
    assert_eq!(copied.relocations(), ["back in the queue of left"]);
}

#[test]
fn a_build_whose_name_another_file_has_is_published_when_that_is_out() {
    let mut farm = two_printers("approve = \"always\"\n");
    farm.drop_part("a.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.order(CommandKind::Flush, None);
    farm.pass_until("it waits for a yes", |farm| farm.has_alert(AlertKind::ReleaseDue));
    let build = farm.ask(async |ledger| ledger.builds_in_state(BuildState::Verified).await.unwrap()).remove(0);
    let file = queue(&farm, "left").join(build.staged.file_name.unwrap());
    fs::write(&file, b"another").unwrap();
    farm.say(&OperatorWord::Release { build: build.id, seen: None }, false).unwrap();
    farm.pass_until("it is told", |farm| {
        farm.alert_text(AlertKind::QueueAltered).contains("name of the build: take it out")
    });
    assert!(!farm.has_alert(AlertKind::PublishingFails));
    fs::remove_file(&file).unwrap();
    farm.pass_until("it is published", |farm| visible(farm) == [1, 0]);
    farm.pass_until("it is over", |farm| !farm.has_alert(AlertKind::QueueAltered));
    farm.assert_ledger_agrees_with_folders();
}
