//! Keeps the house in order: a module knows only floors below its own, and no files of a room import each other in a circle.

use std::{
    fs,
    path::{Path, PathBuf},
};

mod imports;

/// Rooms whose files still import each other in a circle. It only becomes shorter.
const STILL_KNOTTED: [&str; 4] = ["geometry", "nest", "format", "farm"];

/// Rooms and their floors, as in `ARCHITECTURE.md`.
const FLOORS: [(&str, u32); 16] = [
    ("geometry", 0),
    ("pollination", 0),
    ("nest", 1),
    ("samples", 1),
    ("format", 2),
    ("access", 2),
    ("build", 3),
    ("ledger", 4),
    ("intake", 4),
    ("queue", 4),
    ("settings", 5),
    ("farm", 6),
    ("metrics", 6),
    ("outbox", 6),
    ("web", 7),
    ("cli", 8),
];

fn rust_files(dir: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(dir).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(rust_files(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
    files.sort();
    files
}

fn floor(room: &str) -> Option<u32> {
    FLOORS.iter().find(|(name, _)| *name == room).map(|&(_, floor)| floor)
}

/// Rooms that a source text names after `crate::`, inside braces too.
fn rooms_named(text: &str) -> Vec<String> {
    let mut rooms = Vec::new();
    for (at, _) in text.match_indices("crate::") {
        let rest = &text[at + "crate::".len()..];
        let names = match rest.strip_prefix('{') {
            Some(list) => top_level_names(list),
            None => vec![rest],
        };
        for name in names {
            let name: String = name.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            // What follows the last comma of a list over several lines names nothing.
            if !name.is_empty() {
                rooms.push(name);
            }
        }
    }
    rooms
}

/// The names at depth one of a `{a::b, c::{d, e}}` list, given what follows the first brace.
fn top_level_names(list: &str) -> Vec<&str> {
    let (mut depth, mut start, mut names) = (1, 0, Vec::new());
    for (at, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        if depth == 0 || (depth == 1 && c == ',') {
            names.push(&list[start..at]);
            start = at + 1;
        }
        if depth == 0 {
            break;
        }
    }
    names
}

#[test]
fn a_module_knows_only_floors_below_its_own() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut faults = Vec::new();
    let mut seen = 0;
    for file in rust_files(&source) {
        let room = file.strip_prefix(&source).unwrap().components().next().unwrap();
        let room = room.as_os_str().to_str().unwrap().trim_end_matches(".rs").to_owned();
        if room == "lib" || room == "main" {
            continue;
        }
        let own = floor(&room).unwrap_or_else(|| panic!("{} is in no known room", file.display()));
        for named in rooms_named(&fs::read_to_string(&file).unwrap()) {
            if named == room {
                continue;
            }
            seen += 1;
            match floor(&named) {
                Some(other) if other < own => {}
                Some(other) => faults.push(format!("{}: {room} ({own}) names {named} ({other})", file.display())),
                None => faults.push(format!("{}: `crate::{named}` is no room", file.display())),
            }
        }
    }
    assert!(seen > 0, "no room names another: the test reads nothing");
    assert!(faults.is_empty(), "rooms on the wrong floor:\n{}", faults.join("\n"));
}

#[test]
fn the_reader_of_this_test_sees_plain_and_braced_paths() {
    let text = "use crate::nest::Config; use crate::{format::{Unit, Limits}, geometry,\n};";
    assert_eq!(rooms_named(text), ["nest", "format", "geometry"]);
}

#[test]
fn no_files_of_a_room_import_each_other_in_a_circle() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut faults = Vec::new();
    for (room, _) in FLOORS {
        let imports = imports::imports_of(&source, room);
        let circles = imports::circles(&imports);
        match STILL_KNOTTED.contains(&room) {
            true if circles.is_empty() => {
                faults.push(format!("{room} has no circle any more: take it out of STILL_KNOTTED"))
            }
            true => {}
            false => faults.extend(circles.iter().map(|circle| in_words(circle))),
        }
    }
    assert!(faults.is_empty(), "files that import each other:\n{}", faults.join("\n"));
}

/// `web/admit -> web/server -> web/admit`.
fn in_words(circle: &[imports::ModulePath]) -> String {
    let back = circle.iter().chain(circle.first());
    back.map(|module| module.join("/")).collect::<Vec<_>>().join(" -> ")
}
