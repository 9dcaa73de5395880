//! Tickets and lists that people write, from the hot folder to the waiting part.

use std::{fs, path::Path};

use super::{HandDrivenFarm, QUICK, block, stl};
use crate::{
    farm::AlertKind,
    intake::is_copies_question,
    ledger::{PartRow, PartState},
};

/// The ticket that the README shows, as somebody copies it.
fn readme_ticket() -> String {
    let readme = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).unwrap();
    let section = readme.split_once("**A ticket beside the part**").unwrap().1;
    let lines = section.lines().skip_while(|line| !line.starts_with("    ")).take_while(|line| !line.is_empty());
    lines.map(|line| format!("{line}\n")).collect()
}

fn wait_for_part(farm: &mut HandDrivenFarm) -> PartRow {
    let taken = |farm: &HandDrivenFarm| {
        [PartState::Waiting, PartState::Batched, PartState::Built, PartState::Rejected]
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
    assert_ne!(part.state, PartState::Rejected, "{}", part.rejection.reason);
    assert_eq!((part.owed.copies, part.terms.order_name.as_str(), part.terms.priority), (10, "1042", 80));
    assert_eq!(part.warnings, "");
}

#[test]
fn a_number_of_copies_that_is_not_clear_is_asked_for() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("bracketx4.stl", &block(10.0, 10.0, 10.0));
    let part = wait_for_part(&mut farm);
    assert_eq!(part.owed.copies, 1);
    assert!(part.warnings.lines().any(is_copies_question) && part.warnings.contains("bracketx4"), "{}", part.warnings);
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
    assert!(farm.parts(PartState::Rejected).is_empty());
}
