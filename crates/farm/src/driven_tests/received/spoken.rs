//! What a farm writes into folders comes from the catalogs: `STATUS.txt`, its alerts, and the reasons beside refused files.

use std::{collections::BTreeSet, fs};

use language::{Language, unsaid_words};
use ledger::{CommandKind, PartState};

use crate::{
    AlertKind,
    driven_tests::{HandDrivenFarm, QUICK, block, stl},
};

/// What is no text of ours: names of files, machines and people, values of settings, words that programs read, and units.
fn is_data(word: &str) -> bool {
    const DATA: &[&str] = &[
        "test",
        "mm",
        "ann@farm",
        "a@test",
        "h",
        "s",
        "inch",
        "unit",
        "mesh_errors",
        "A-7",
        "UTC",
        "host",
        "free",
        "STL",
        "large",
        "Claim",
        "Inode",
        "nestd",
    ];
    let is_name =
        [".stl", ".pdf", ".toml", ".csv", ".txt", ".3mf", "/", "bracketx4"].iter().any(|piece| word.contains(piece));
    // Of commands in backticks, and of times.
    let is_of_command = ["edit", "--copies", "N"].contains(&word) || word.ends_with('Z') && word.len() == 3;
    let is_id = word.chars().filter(char::is_ascii_digit).count() >= 4;
    DATA.contains(&word) || is_name || is_id || is_of_command
}

/// What no catalog said of the texts.
fn unsaid<'t>(texts: impl IntoIterator<Item = &'t str>) -> BTreeSet<String> {
    let lines = texts.into_iter().flat_map(str::lines);
    let faults = lines.filter_map(|line| {
        let words: Vec<String> = unsaid_words(line).into_iter().filter(|word| !is_data(word)).collect();
        (!words.is_empty()).then(|| format!("{}: {line}", words.join(" ")))
    });
    faults.collect()
}

/// Sets the language of what a farm writes into folders, also to one that no setting names.
fn speak(farm: &mut HandDrivenFarm, language: Language) {
    farm.settings_mut().language = language;
}

/// The reasons in the error folder.
fn reasons(farm: &HandDrivenFarm) -> Vec<String> {
    let files = intake::files_below(&farm.folder("error")).unwrap_or_default();
    let reasons = files.iter().filter(|file| file.to_string_lossy().ends_with(".reason.txt"));
    reasons.map(|file| fs::read_to_string(file).unwrap()).collect()
}

#[test]
fn all_that_lies_in_folders_is_in_the_language_of_the_farm() {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}incomplete_secs = 3\n[trigger]\nmax_wait_secs = \"24h\"\n"));
    speak(&mut farm, Language::Marked);
    farm.pass_until("the status is said again", |farm| farm.status_text().contains('⟦'));
    farm.pass_secs(2.0);
    let cube = |side| stl(&block(side, side, side));
    for (name, bytes) in [
        ("torn.stl", &cube(10.0)[..300]),
        ("drawing.pdf", b"%PDF-1.7 of a part".as_slice()),
        ("empty.stl", b"".as_slice()),
        ("large.stl", &cube(500.0)),
        ("open.stl", &cube(9.0)[..84 + 50 * 12]),
        ("alone.stl.toml", b"copies = 2\n"),
        ("broken.stl", &cube(8.0)),
        ("broken.stl.toml", b"copies = 0\n"),
        ("bracketx4.stl", &cube(11.0)),
        ("speck.stl", &cube(0.2)),
        ("A-7/listed.stl", &cube(12.0)),
        ("A-7/order.csv", b"file,copies\nother.stl,2\n"),
    ] {
        farm.drop_bytes(name, bytes);
    }
    let texts = |farm: &HandDrivenFarm| {
        let status = fs::read_to_string(farm.folder("inbox").join("STATUS.txt")).unwrap_or_default();
        let alerts = [AlertKind::Incomplete, AlertKind::Question, AlertKind::Refused];
        let alerts = alerts.map(|kind| Language::Marked.within(|| farm.alert_text(kind)));
        let mut texts = reasons(farm);
        texts.extend(alerts.into_iter().chain([status, Language::Marked.within(|| farm.status_text())]));
        texts
    };
    farm.pass_secs(2.0);
    let mut seen = texts(&farm);
    farm.pass_secs(12.0);
    seen.extend(texts(&farm));
    let waiting = farm.parts(PartState::Waiting);
    farm.order_and_wait(CommandKind::Cancel, Some(waiting[0].id));
    farm.pass_secs(2.0);
    seen.extend(texts(&farm));
    assert!(reasons(&farm).len() >= 7, "{:#?}", reasons(&farm));
    assert!(seen.iter().any(|text| text.contains("ATTENTION")), "{seen:#?}");
    let faults: Vec<String> = unsaid(seen.iter().map(String::as_str)).into_iter().collect();
    assert!(faults.is_empty(), "no catalog says: {}", faults.join("\n"));
}

#[test]
fn a_reason_names_its_part_in_each_language_and_is_found_after_the_language_has_changed() {
    let mut farm = HandDrivenFarm::open(QUICK);
    speak(&mut farm, Language::German);
    farm.drop_bytes("torn.stl", &stl(&block(10.0, 10.0, 10.0))[..300]);
    let part = farm.wait_for_parts(PartState::Refused, 1).remove(0);
    farm.pass_until("its reason is there", |farm| !reasons(farm).is_empty());
    let reason = reasons(&farm).concat();
    assert!(
        reason.contains(&format!("Teil {} der Maschine test.", part.id)) && reason.contains("wurde abgelehnt"),
        "{reason}"
    );
    assert!(!part.refused.reason.contains("Datei"), "the ledger is English: {}", part.refused.reason);
    speak(&mut farm, Language::Japanese);
    farm.pass_until("it is counted", |farm| farm.has_alert(AlertKind::Refused));
    farm.order_and_wait(CommandKind::Retry, Some(part.id));
    farm.pass_until("it is refused again", |farm| {
        let reasons = reasons(farm);
        reasons.len() == 1 && reasons[0].contains("のパーツ")
    });
}
