//! Tickets and lists that people write, from the hot folder to the waiting part.

use std::{fs, path::Path};

use build_file::is_copies_question;
use ledger::{
    CommandArgument, CommandKind, CommandState, EventKind, NewCommand, PartEdit, PartRow, PartState, QuestionKind,
};

use crate::{
    AlertKind, PartQuestion,
    driven_tests::{HandDrivenFarm, QUICK, block, hand_driven_farm::farm_files::leaning_block, stl},
};

/// The ticket that docs/technician.md shows, as somebody copies it.
fn readme_ticket() -> String {
    let readme = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/technician.md")).unwrap();
    let section = readme.split_once("**A ticket beside the part**").unwrap().1;
    let lines = section.lines().skip_while(|line| !line.starts_with("    ")).take_while(|line| !line.is_empty());
    lines.map(|line| format!("{line}\n")).collect()
}

fn wait_for_part(farm: &mut HandDrivenFarm) -> PartRow {
    let taken = |farm: &HandDrivenFarm| {
        [PartState::Waiting, PartState::Batched, PartState::Built, PartState::Refused]
            .into_iter()
            .flat_map(|state| farm.parts(state))
            .next()
    };
    farm.pass_until("the part is read", |farm| taken(farm).is_some());
    taken(farm).unwrap()
}

#[test]
fn the_ticket_of_the_readme_copied_whole_is_accepted() {
    let ticket = readme_ticket();
    let words =
        ["copies", "order", "due", "priority", "orientation", "keep_up", "not_down", "clearance_mm", "unit", "note"];
    assert!(words.iter().all(|word| ticket.contains(&format!("{word} = "))), "{ticket}");
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}[trigger]\nmax_wait_secs = \"24h\"\n"));
    // One inch high.
    farm.drop_bytes("bracket.stl", &stl(&block(1.0, 0.5, 0.5)));
    farm.drop_bytes("bracket.stl.toml", ticket.as_bytes());
    let part = wait_for_part(&mut farm);
    assert_ne!(part.state, PartState::Refused, "{}", part.refused.reason);
    assert_eq!((part.owed.copies, part.terms.order_name.as_str(), part.terms.priority), (10, "1042", 80));
    assert_eq!(part.warnings, "");
}

#[test]
fn a_number_of_copies_that_is_not_clear_is_asked_for() {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}[trigger]\nmax_wait_secs = \"24h\"\n"));
    farm.drop_part("bracketx4.stl", &block(10.0, 10.0, 10.0));
    let part = wait_for_part(&mut farm);
    assert_eq!(part.owed.copies, 1);
    assert!(part.warnings.lines().any(is_copies_question) && part.warnings.contains("bracketx4"), "{}", part.warnings);
    let status =
        |farm: &HandDrivenFarm| fs::read_to_string(farm.folder("inbox").join("STATUS.txt")).unwrap_or_default();
    let asked = format!(
        "Question: How many copies? part {0} (bracketx4.stl) is taken as 1; answer with `nestd edit {0} --copies N`.",
        part.id
    );
    farm.pass_until("it is asked", |farm| status(farm).contains(&asked));
    for (at, name) in ["clipx4.stl", "hookx4.stl", "plugx4.stl", "coverx4.stl"].into_iter().enumerate() {
        farm.drop_part(name, &block(10.0, 10.0, 11.0 + at as f64));
    }
    farm.wait_for_parts(PartState::Waiting, 5);
    farm.pass_until("the rest is counted", |farm| status(farm).contains("The same is asked of 2 more parts."));
    assert_eq!(status(&farm).matches("Question:").count(), 3);
    let questions = farm.status_json()["questions"].clone();
    assert_eq!(questions[0]["kind"], "copies", "{questions:#}");
    assert!(questions[0]["remedy"].as_str().unwrap().starts_with("`nestd edit "), "{questions:#}");
    answer_in_every_way(&mut farm);
}

/// Any number that is told ends the question, also the one that was taken.
fn answer_in_every_way(farm: &mut HandDrivenFarm) {
    let id = |farm: &HandDrivenFarm, name: &str| {
        farm.parts(PartState::Waiting).into_iter().find(|part| part.name == name).unwrap().id
    };
    let command = |kind, part, argument| NewCommand {
        kind,
        machine: String::new(),
        part: Some(part),
        argument,
        asked_by: "ann@farm".to_owned(),
    };
    let edit = |copies| CommandArgument {
        copies: None,
        edit: Some(PartEdit { copies: Some(copies), ..PartEdit::default() }),
        ..CommandArgument::default()
    };
    let one = id(farm, "bracketx4.stl");
    let four = id(farm, "plugx4.stl");
    let commands = [
        command(CommandKind::Edit, one, edit(1)),
        command(CommandKind::Confirm, id(farm, "hookx4.stl"), CommandArgument::default()),
        command(CommandKind::Edit, four, edit(4)),
        // It is wanted once again, and that is not asked.
        command(
            CommandKind::Cancel,
            four,
            CommandArgument { copies: Some(3), edit: None, ..CommandArgument::default() },
        ),
    ];
    for command in commands {
        let number = farm.submit_command(&command);
        let find = |farm: &HandDrivenFarm| farm.ask(async |ledger| ledger.find_command(number).await.unwrap().unwrap());
        farm.pass_until("it is answered", |farm| find(farm).answered_at.is_some());
        assert_eq!(find(farm).state, CommandState::Done, "{}", find(farm).answer);
        assert!(!find(farm).answer.contains("already"), "{}", find(farm).answer);
    }
    farm.drop_bytes("clipx4.stl.toml", b"copies = 1\n");
    let is_asked = |part: &PartRow| part.warnings.lines().any(is_copies_question);
    farm.pass_until("only one is asked for", |farm| {
        farm.parts(PartState::Waiting).iter().filter(|part| is_asked(part)).count() == 1
    });
    assert!(farm.parts(PartState::Waiting).iter().all(|part| is_asked(part) == (part.name == "coverx4.stl")));
    assert!(farm.parts(PartState::Waiting).iter().all(|part| part.wanted_copies() == 1));
    farm.pass_until("nothing else is asked", |farm| farm.status_text().matches("Question:").count() == 1);
    let told = farm.ask(async |ledger| ledger.events_of_part(one).await.unwrap()).pop().unwrap();
    assert_eq!((told.kind, told.detail.as_str()), (EventKind::Edited, "ann@farm: 1 copy, as it was taken"));
}

#[test]
fn the_number_of_copies_is_asked_and_answered_also_while_the_build_is_made_and_is_asked_no_more_afterwards() {
    for is_answered in [true, false] {
        let mut farm = HandDrivenFarm::open(&QUICK.replace("final_secs = 0.05", "final_secs = 3.0"));
        farm.drop_part("bracketx4.stl", &leaning_block());
        farm.wait_for_parts(PartState::Waiting, 1);
        farm.order(CommandKind::Flush, None);
        farm.pass_moments_until("its build is made", |farm| !farm.parts(PartState::Batched).is_empty());
        let part = farm.parts(PartState::Batched).remove(0);
        let kinds = |part: &PartRow| {
            PartQuestion::of_part(part, &Default::default()).into_iter().map(|asked| asked.kind).collect::<Vec<_>>()
        };
        assert_eq!(kinds(&part), [QuestionKind::Copies]);
        assert_eq!(farm.ask(async |ledger| ledger.parts_with_questions(9).await.unwrap()).len(), 1);
        if is_answered {
            let confirm = farm.order(CommandKind::Confirm, Some(part.id));
            let find =
                |farm: &HandDrivenFarm| farm.ask(async |ledger| ledger.find_command(confirm).await.unwrap().unwrap());
            farm.pass_moments_until("it is answered", |farm| find(farm).answered_at.is_some());
            assert_eq!(find(&farm).state, CommandState::Done, "{}", find(&farm).answer);
        }
        farm.pass_moments_until("it is built", |farm| !farm.parts(PartState::Built).is_empty());
        let built = farm.parts(PartState::Built).remove(0);
        assert_eq!(kinds(&built), []);
        let told = built.told_warnings().collect::<Vec<_>>().join(" ");
        assert!(!told.contains("How many copies?") && told.contains("Taken as 1 copy") != is_answered, "{told}");
        let answer = farm.order_and_wait(CommandKind::Confirm, Some(built.id)).answer;
        assert!(answer.contains("waits for no confirmation"), "{answer}");
    }
}

#[test]
fn a_ticket_without_its_part_is_told_and_refused_in_the_end() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_bytes("order-7/a.stl.toml", b"copies = 3\n");
    farm.pass_until("it is told", |farm| farm.has_alert(AlertKind::Incomplete));
    let refused = farm.folder("error").join("order-7/a.stl.toml.reason.txt");
    farm.pass_until("it is refused", |_| refused.exists());
    farm.pass_until("nothing waits any more", |farm| !farm.has_alert(AlertKind::Incomplete));
}

#[test]
fn a_control_file_is_no_part_and_one_with_content_is_refused() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_bytes("pause", b"please\n");
    let reason = farm.folder("error").join("pause.reason.txt");
    farm.pass_until("it is refused", |_| reason.exists());
    assert!(fs::read_to_string(reason).unwrap().contains("Put an empty file of that name"));
    assert!(farm.parts(PartState::Refused).is_empty());
}

/// A farm with a list beside loose files: one is named, one is not, and one row has no file.
fn farm_with_loose_list(unlisted: &str) -> HandDrivenFarm {
    let mut farm = HandDrivenFarm::open(&format!(
        "{QUICK}incomplete_secs = 8\nunlisted = \"{unlisted}\"\n[trigger]\nmax_wait_secs = \"24h\"\n"
    ));
    farm.drop_bytes("order.csv", b"file;copies\na.stl;2\nlost.stl;1\n");
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    farm.drop_part("new.stl", &block(12.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.pass_until("it is told", |farm| farm.has_alert(AlertKind::Incomplete));
    assert_eq!(farm.parts(PartState::Waiting)[0].name, "a.stl");
    farm
}

#[test]
fn a_loose_part_that_its_list_does_not_name_waits_and_is_refused() {
    let mut farm = farm_with_loose_list("refuse");
    let reason = farm.folder("error").join("new.stl.reason.txt");
    let list = farm.folder("error").join("order.csv.reason.txt");
    farm.pass_until("both are refused", |_| reason.exists() && list.exists());
    assert!(fs::read_to_string(list).unwrap().contains("lost.stl"));
    assert!(fs::read_to_string(reason).unwrap().contains("stands in none of the 2 rows of order.csv"));
    assert_eq!(farm.parts(PartState::Waiting).len(), 1);
}

#[test]
fn a_loose_part_that_its_list_does_not_name_is_asked_about_where_it_is_taken() {
    let mut farm = farm_with_loose_list("warn");
    let parts = farm.wait_for_parts(PartState::Waiting, 2);
    let new = parts.iter().find(|part| part.name == "new.stl").unwrap();
    assert_eq!(new.owed.copies, 1);
    assert!(new.warnings.lines().any(is_copies_question), "{}", new.warnings);
}
