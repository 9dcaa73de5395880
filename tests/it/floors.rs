//! Checks the layering: crates and modules use only lower floors, and the files of a crate or module do not import
//! each other in a circle.

use std::{
    fs,
    path::{Path, PathBuf},
};

use toml::Table;

mod imports;

/// Crates of the workspace and their floors, as in `ARCHITECTURE.md`.
const CRATES: [(&str, u32); 13] = [
    ("solids", 0),
    ("jobs", 0),
    ("language", 0),
    ("sample-parts", 1),
    ("nester", 2),
    ("build-file", 2),
    ("access", 2),
    ("delivery", 3),
    ("ledger", 4),
    ("intake", 4),
    ("ledger-fixtures", 5),
    ("settings", 5),
    ("farm", 6),
];

/// Packages below `crates` that are workspaces of their own.
const OTHER_WORKSPACES: [&str; 1] = ["nester-python"];

/// Crates that remember nothing and have no clock.
const PURE: [&str; 5] = ["solids", "jobs", "sample-parts", "nester", "build-file"];

/// Rooms (modules of `nestd`) and their floors, as in `ARCHITECTURE.md`.
const FLOORS: [(&str, u32); 5] = [("outbox", 6), ("metrics", 7), ("tables", 7), ("web", 8), ("cli", 9)];

/// The most source files that stand in one folder.
const FULLEST_FOLDER: usize = 15;

/// The folders of each crate or room in their order, and files that stand beside them, as `ARCHITECTURE.md` lists them: each knows only
/// earlier ones.
fn folders() -> Vec<(String, Vec<String>)> {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("ARCHITECTURE.md")).unwrap();
    let (_, table) = text.split_once("| crate or room | folders |\n|---|---|\n").unwrap();
    let rows = table.lines().take_while(|line| line.starts_with('|'));
    let names = |row: &str| row.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>();
    let found: Vec<_> = rows.map(names).map(|mut names| (names.remove(0), names)).collect();
    assert_eq!(found.len(), 11, "{found:?}");
    found
}

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

/// The modules that a source text mentions after `crate::`, also inside braces.
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
            // A multi-line list has no name after its last comma.
            if !name.is_empty() {
                rooms.push(name);
            }
        }
    }
    rooms
}

/// The top-level names of a list `{a::b, c::{d, e}}`. `list` is the text after the first brace.
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
fn a_crate_depends_on_crates_of_lower_floors_only() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates");
    let mut found: Vec<String> =
        (fs::read_dir(&crates).unwrap()).map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    found.retain(|name| !OTHER_WORKSPACES.contains(&name.as_str()));
    found.sort();
    let mut known: Vec<&str> = CRATES.iter().map(|&(name, _)| name).collect();
    known.sort_unstable();
    assert_eq!(found, known);
    let floor = |name: &str| CRATES.iter().find(|(known, _)| *known == name).map(|&(_, floor)| floor);
    for (name, own) in CRATES {
        let manifest: Table = fs::read_to_string(crates.join(name).join("Cargo.toml")).unwrap().parse().unwrap();
        for table in ["dependencies", "dev-dependencies", "build-dependencies"] {
            let Some(dependencies) = manifest.get(table).and_then(|table| table.as_table()) else { continue };
            for other in dependencies.keys().filter_map(|other| floor(other).map(|floor| (other, floor))) {
                assert!(other.1 < own, "{name} ({own}) depends on {} ({})", other.0, other.1);
            }
            assert!(!dependencies.contains_key("nestd"), "{name} depends on nestd");
        }
    }
}

/// Files that see the whole farm: what is below `core`, the loop, and what opens the farm.
const SEE_THE_WHOLE_FARM: [&str; 4] = ["core", "run/event_loop.rs", "run/open.rs", "run/reload.rs"];

#[test]
fn a_step_gets_a_desk_and_never_the_whole_farm() {
    let farm = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/farm/src");
    let mut faults = Vec::new();
    let mut lent = 0;
    for file in rust_files(&farm).into_iter().filter(|file| !file.starts_with(farm.join("driven_tests"))) {
        let text = fs::read_to_string(&file).unwrap();
        let borrows = |(at, name): (usize, &str)| {
            let (before, after) = (&text[..at], &text[at + name.len()..]);
            (before.ends_with("&mut ") || before.ends_with('&') || before.ends_with("'f mut "))
                && !after.starts_with(|c: char| c.is_alphanumeric() || c == '_')
        };
        let found = text.match_indices("Farm").filter(|&found| borrows(found)).count();
        match SEE_THE_WHOLE_FARM.iter().any(|place| file.starts_with(farm.join(place))) {
            true => lent += found,
            false if found > 0 => faults.push(format!("{} borrows the farm", file.display())),
            false => {}
        }
    }
    assert!(lent > 10, "the test reads nothing");
    assert!(faults.is_empty(), "give these steps a desk of their kind:\n{}", faults.join("\n"));
}

/// Files outside `delivery/queue` that know which queues are folders: what reads and checks the settings, what leases and checks the folders of
/// a machine, and what compares them with the ledger.
const KNOW_QUEUE_FOLDERS: [&str; 12] = [
    "crates/farm/src/leases/folder_check.rs",
    "crates/farm/src/leases/folder_leases.rs",
    "crates/farm/src/records/folder_builds.rs",
    "crates/farm/src/records/invariants/builds.rs",
    "crates/farm/src/records/ledger_freshness.rs",
    "crates/settings/src/machine/profile.rs",
    "crates/settings/src/service/settings.rs",
    "crates/settings/src/validation/load.rs",
    "crates/settings/src/validation/printer_validation.rs",
    "crates/settings/src/validation/profile_snapshot.rs",
    "crates/settings/src/validation/validation_rules.rs",
    "src/cli/serve/check/folders.rs",
];

/// What names the folder that a queue is.
const NAMES_OF_QUEUE_FOLDERS: [&str; 5] =
    ["QueueFolder", "QueueAddress::Folder", "queue_folders(", "queue.folder()", "folders.queue"];

#[test]
fn a_step_works_with_the_queue_of_a_printer_and_does_not_know_that_it_is_a_folder() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = Vec::new();
    for file in ["crates/farm/src", "crates/settings/src", "src"].iter().flat_map(|place| rust_files(&root.join(place)))
    {
        let place = file.strip_prefix(root).unwrap().to_str().unwrap().to_owned();
        if place.contains("tests") {
            continue;
        }
        // Names of options stand in quotes.
        let text = fs::read_to_string(&file).unwrap().replace("\"folders.queue\"", "");
        if NAMES_OF_QUEUE_FOLDERS.iter().any(|name| text.contains(name)) {
            found.push(place);
        }
    }
    assert_eq!(found, KNOW_QUEUE_FOLDERS, "ask the queue (`PrinterQueue`, `QueueAddress`) instead");
}

#[test]
fn the_optimiser_knows_nothing_of_solids_and_layouts() {
    let room = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/nester/src/pollination");
    for file in rust_files(&room) {
        let text = fs::read_to_string(&file).unwrap();
        let is_free = ["crate::", "super::super", "solids::"].into_iter().all(|path| !text.contains(path));
        assert!(is_free, "{} knows what it optimises", file.display());
    }
}

#[test]
fn the_pure_crates_remember_nothing_for_the_whole_process_and_only_the_stop_rule_has_a_clock() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates");
    let mut faults = Vec::new();
    for name in PURE {
        for file in rust_files(&crates.join(name).join("src")) {
            let text = fs::read_to_string(&file).unwrap();
            let code = || text.lines().map(str::trim_start).filter(|line| !line.starts_with("//"));
            let is_static = |line: &str| line.split_whitespace().take(3).any(|word| word == "static");
            // A `OnceLock` that is no static belongs to the value that holds it.
            let remembers = ["LazyLock", "thread_local!"];
            if code().any(|line| is_static(line) || remembers.iter().any(|kind| line.contains(kind))) {
                faults.push(format!("{} has process-wide memory", file.display()));
            }
            let is_stop_rule = file.ends_with("nester/src/problem/search_budget.rs");
            if !is_stop_rule && code().any(|line| line.contains("Instant") || line.contains("SystemTime")) {
                faults.push(format!("{} looks at a clock", file.display()));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn the_reader_of_this_test_sees_plain_and_braced_paths() {
    let text = "use crate::outbox::Mail; use crate::{tables::{Column, Cell}, metrics,\n};";
    assert_eq!(rooms_named(text), ["outbox", "tables", "metrics"]);
}

#[test]
fn no_files_of_a_crate_or_a_room_import_each_other_in_a_circle() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let rooms = FLOORS.map(|(room, _)| imports::imports_of(&root.join("src"), &[room]));
    let crates = CRATES.map(|(name, _)| imports::imports_of(&root.join("crates").join(name).join("src"), &[]));
    let faults: Vec<String> =
        rooms.iter().chain(&crates).flat_map(imports::circles).map(|circle| in_words(&circle)).collect();
    assert!(
        crates.iter().filter(|imports| imports.len() > 2).all(|imports| imports.values().any(|to| !to.is_empty())),
        "a crate of which nothing is read"
    );
    assert!(faults.is_empty(), "files that import each other:\n{}", faults.join("\n"));
}

#[test]
fn a_folder_knows_only_earlier_folders_of_its_room() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut faults = Vec::new();
    for (place, folders) in &folders() {
        let (imports, depth) = match place.strip_prefix("src/") {
            Some(room) => (imports::imports_of(&root.join("src"), &[room]), 1),
            None => (imports::imports_of(&root.join(place).join("src"), &[]), 0),
        };
        let rank = |module: &imports::ModulePath| folders.iter().position(|name| Some(name) == module.get(depth));
        for (module, targets) in imports.iter().filter(|(module, _)| module.len() > depth) {
            let Some(own) = rank(module) else {
                faults.push(format!("{place}: {} stands in no known folder", module.join("/")));
                continue;
            };
            let later = targets.iter().filter(|target| {
                target.len() > depth && target[..depth] == module[..depth] && rank(target).is_none_or(|rank| rank > own)
            });
            faults.extend(later.map(|target| format!("{place}: {} knows {}", module.join("/"), target.join("/"))));
        }
        assert!(imports.keys().filter(|module| module.len() > depth + 1).count() > 5, "{place}: no folder is read");
    }
    assert!(faults.is_empty(), "folders that know later ones:\n{}", faults.join("\n"));
}

#[test]
fn a_folder_has_at_most_15_files_and_a_head() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut counts: std::collections::BTreeMap<PathBuf, usize> = std::collections::BTreeMap::new();
    for file in ["src", "crates", "tests"].iter().flat_map(|place| rust_files(&root.join(place))) {
        *counts.entry(file.parent().unwrap().strip_prefix(root).unwrap().to_owned()).or_default() += 1;
    }
    let full = counts.iter().filter(|(_, count)| **count > FULLEST_FOLDER);
    let mut faults: Vec<String> = full.map(|(folder, count)| format!("{}: {count} files", folder.display())).collect();
    for (place, folders) in &folders() {
        let source = if place.starts_with("crates/") { root.join(place).join("src") } else { root.join(place) };
        let heads = folders.iter().map(|folder| source.join(folder).join("mod.rs")).filter(|head| head.exists());
        let bare = heads.filter(|head| !fs::read_to_string(head).unwrap().starts_with("//! "));
        faults.extend(bare.map(|head| format!("{} does not say what the folder is for", head.display())));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// `web/admit -> web/server -> web/admit`.
fn in_words(circle: &[imports::ModulePath]) -> String {
    let back = circle.iter().chain(circle.first());
    back.map(|module| module.join("/")).collect::<Vec<_>>().join(" -> ")
}
