//! Checks the code style: short files, short functions, no open to-dos.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

const MAX_FILE_LINES: usize = 400;
const MAX_FUNCTION_LINES: usize = 70;

fn rust_files(dir: &Path, files: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(dir) else { return };
    for entry in entries {
        let path = entry.unwrap().path();
        if path.is_dir() {
            rust_files(&path, files);
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
}

fn all_files() -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    for dir in ["src", "crates", "tests", "benches"] {
        rust_files(&root.join(dir), &mut files);
    }
    files.into_iter().map(|f| (f.clone(), fs::read_to_string(f).unwrap())).collect()
}

/// (first line, length) of every function; the indentation of rustfmt shows where a function ends.
fn functions(text: &str) -> Vec<(usize, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let mut found = Vec::new();
    for (at, line) in lines.iter().enumerate() {
        let code = line.trim_start();
        let indent = line.len() - code.len();
        let head = code.split('(').next().unwrap_or("");
        let is_function = head.split(' ').any(|word| word == "fn") && !code.starts_with("//") && !code.ends_with(';');
        if !is_function {
            continue;
        }
        let close = format!("{}}}", " ".repeat(indent));
        if let Some(length) = lines[at..].iter().position(|l| *l == close) {
            found.push((at + 1, length + 1));
        }
    }
    found
}

#[test]
fn no_file_is_longer_than_400_lines() {
    let long: Vec<String> = (all_files().iter())
        .map(|(file, text)| (file, text.lines().count()))
        .filter(|&(_, lines)| lines > MAX_FILE_LINES)
        .map(|(file, lines)| format!("{} {lines}", file.display()))
        .collect();
    assert!(long.is_empty(), "split these:\n{}", long.join("\n"));
}

#[test]
fn no_function_is_longer_than_70_lines() {
    let mut long = Vec::new();
    for (file, text) in all_files() {
        for (line, length) in functions(&text) {
            if length > MAX_FUNCTION_LINES {
                long.push(format!("{}:{line} {length}", file.display()));
            }
        }
    }
    assert!(long.is_empty(), "split these:\n{}", long.join("\n"));
}

#[test]
fn nothing_is_left_open() {
    let words = [
        concat!("TO", "DO"),
        concat!("FIX", "ME"),
        concat!("todo", "!("),
        concat!("unimplemented", "!("),
        concat!("#[ign", "ore]"),
    ];
    let mut open = Vec::new();
    for (file, text) in all_files() {
        for (at, line) in text.lines().enumerate() {
            if words.iter().any(|w| line.contains(w)) {
                open.push(format!("{}:{}: {line}", file.display(), at + 1));
            }
        }
    }
    assert!(open.is_empty(), "left open:\n{}", open.join("\n"));
}

/// Names of the types that the code of a file defines; tests are left out.
fn type_names(text: &str) -> Vec<&str> {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let name_of = |line: &'_ str| {
        let words = line.trim_start().trim_start_matches("pub(crate) ").trim_start_matches("pub(super) ");
        let (kind, rest) = words.trim_start_matches("pub ").split_once(' ')?;
        let name = rest.split(|c: char| !c.is_alphanumeric()).next()?;
        (["struct", "enum", "trait"].contains(&kind) && !name.is_empty())
            .then(|| line.find(name).map(|at| (at, name.len())))?
    };
    code.lines().filter_map(|line| name_of(line).map(|(at, length)| &line[at..at + length])).collect()
}

#[test]
fn a_type_name_has_one_meaning() {
    let mut known: BTreeMap<String, PathBuf> = BTreeMap::new();
    let mut again = Vec::new();
    let is_production = |file: &Path| {
        let path = file.strip_prefix(env!("CARGO_MANIFEST_DIR")).unwrap().to_string_lossy().into_owned();
        (path.starts_with("src") || path.contains("/src/")) && !path.contains("test")
    };
    for (file, text) in all_files().into_iter().filter(|(file, _)| is_production(file)) {
        for name in type_names(&text) {
            if let Some(first) = known.insert(name.to_owned(), file.clone()) {
                again.push(format!("{name}: {} and {}", first.display(), file.display()));
            }
        }
    }
    assert!(known.len() > 400, "only {} types were found", known.len());
    assert!(again.is_empty(), "give these another name:\n{}", again.join("\n"));
}

#[test]
fn each_chosen_fault_stands_once_in_the_file_that_it_names() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let table = fs::read_to_string(root.join("tests/mutants/chosen.txt")).unwrap();
    let mut seen = 0;
    for fault in table.split("\n== ").skip(1) {
        let what = fault.lines().next().unwrap_or_default();
        let (_, rest) = fault.split_once("\nin ").unwrap_or_else(|| panic!("{what}: no line `in FILE`"));
        let file = rest.lines().next().unwrap_or_default();
        // A line that begins with blanks goes on with the one before.
        let mut lines = rest.split_once("\n- ").map_or("", |(_, old)| old).lines();
        let first = lines.next().unwrap_or_default().to_owned();
        let old = lines.take_while(|line| line.starts_with(' ')).fold(first, |old, line| format!("{old}\n{line}"));
        let source = fs::read_to_string(root.join(file)).unwrap_or_else(|error| panic!("{what}: {file}: {error}"));
        assert_eq!(source.matches(&old).count(), 1, "{what}: {old:?} in {file}");
        seen += 1;
    }
    assert!(seen > 90, "{seen}");
}
