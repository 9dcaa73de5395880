//! The README and other documents name only commands, files and modules that exist.

use std::{fs, path::Path, process::Command};

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn the_table_of_commands_has_a_row_for_every_command() {
    let help = Command::new(env!("CARGO_BIN_EXE_nestd")).arg("--help").output().unwrap();
    let help = String::from_utf8(help.stdout).unwrap();
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let commands: Vec<&str> =
        listed.filter_map(|line| line.split_whitespace().next()).filter(|c| *c != "help").collect();
    assert!(commands.len() > 10, "the help lists only {commands:?}");
    let readme = fs::read_to_string(repository().join("docs/commands.md")).unwrap();
    let rows: String = readme.lines().filter(|line| line.starts_with('|')).collect();
    let missing: Vec<&&str> = commands.iter().filter(|c| !rows.contains(&format!("`nestd {c}"))).collect();
    assert!(missing.is_empty(), "no row for {missing:?}");
}

#[test]
fn every_file_that_the_documents_link_to_is_there() {
    let own =
        ["README.md", "ARCHITECTURE.md", "CHANGELOG.md", "CONTRIBUTING.md", "systemd/README.md"].map(str::to_owned);
    let docs = fs::read_dir(repository().join("docs")).unwrap().map(|entry| entry.unwrap().file_name());
    let docs = docs.filter_map(|name| name.into_string().ok()).filter(|name| name.ends_with(".md"));
    for document in own.into_iter().chain(docs.map(|name| format!("docs/{name}"))) {
        let text = fs::read_to_string(repository().join(&document)).unwrap();
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let is_local = !link.starts_with("http") && !link.starts_with('#');
            let from = repository().join(&document);
            assert!(!is_local || from.with_file_name(link).exists(), "{document} links to {link}");
        }
    }
}

#[test]
fn every_room_has_its_place_in_the_architecture() {
    let text = fs::read_to_string(repository().join("ARCHITECTURE.md")).unwrap();
    for floor in ["src", "crates"] {
        for entry in fs::read_dir(repository().join(floor)).unwrap().map(Result::unwrap).filter(|e| e.path().is_dir()) {
            let room = format!("{floor}/{}/", entry.file_name().to_string_lossy());
            assert!(text.contains(&room), "{room} is missing");
        }
    }
}
