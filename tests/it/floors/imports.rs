//! Reads from the sources which files of a module or crate import which. Re-exports are followed to the file that
//! defines the name. Code for tests (`#[cfg(test)]`) does not count.

use std::{
    collections::{BTreeMap, BTreeSet, VecDeque},
    fs,
    path::Path,
};

/// A module by its names below `src`: `["web", "admit"]`.
pub type ModulePath = Vec<String>;

/// The imports between the files of one module or crate.
pub type ImportGraph = BTreeMap<ModulePath, BTreeSet<ModulePath>>;

/// A path in a source text, and whether it is re-exported.
struct NamedPath {
    path: Vec<String>,
    is_public: bool,
}

/// The imports of a module, given its folder; of a whole crate, given its sources and an empty module.
pub fn imports_of(source: &Path, room: &[&str]) -> ImportGraph {
    let mut codes = BTreeMap::new();
    read_module(source, room.iter().map(ToString::to_string).collect(), &mut codes);
    let named: BTreeMap<&ModulePath, Vec<NamedPath>> =
        codes.iter().map(|(path, code)| (path, paths_in(code))).collect();
    // The re-exports of a module: each name, and the path that it stands for.
    let exports = |module: &ModulePath, name: &String| {
        let public = named.get(module)?.iter().filter(|named| named.is_public);
        public.map(|named| &named.path).find(|path| path.last() == Some(name))
    };
    let resolve = |from: &ModulePath, path: &[String]| -> Option<ModulePath> {
        let (mut module, mut rest) = start(from, path, &codes)?;
        loop {
            while let Some((first, others)) = rest.split_first()
                && codes.contains_key(&joined(&module, first))
            {
                (module, rest) = (joined(&module, first), others.to_vec());
            }
            let Some(target) = rest.first().and_then(|name| exports(&module, name)) else { break };
            let Some(next) = start(&module, target, &codes) else { break };
            (module, rest) = next;
        }
        codes.contains_key(&module).then_some(module)
    };
    let mut imports = ImportGraph::new();
    for (module, named) in &named {
        let targets = named.iter().filter(|named| !named.is_public).filter_map(|named| resolve(module, &named.path));
        imports.insert((*module).clone(), targets.filter(|target| target != *module).collect());
    }
    imports
}

/// The shortest circle through each module that is part of a circle; each circle once.
pub fn circles(imports: &ImportGraph) -> BTreeSet<Vec<ModulePath>> {
    let mut circles = BTreeSet::new();
    for start in imports.keys() {
        let mut paths = VecDeque::from([vec![start.clone()]]);
        let mut seen = BTreeSet::new();
        while let Some(path) = paths.pop_front() {
            for next in &imports[&path[path.len() - 1]] {
                if next == start {
                    let first = (0..path.len()).min_by_key(|&at| &path[at]).unwrap_or(0);
                    circles.insert([&path[first..], &path[..first]].concat());
                    paths.clear();
                    break;
                }
                if seen.insert(next.clone()) {
                    paths.push_back([path.as_slice(), std::slice::from_ref(next)].concat());
                }
            }
        }
    }
    circles
}

fn joined(module: &[String], name: &str) -> ModulePath {
    module.iter().cloned().chain([name.to_owned()]).collect()
}

/// The module at which a path starts, and the rest of the path.
fn start(from: &[String], path: &[String], codes: &BTreeMap<ModulePath, String>) -> Option<(ModulePath, Vec<String>)> {
    let first = path.first()?.as_str();
    let ups = path.iter().take_while(|name| *name == "super").count();
    Some(match first {
        "crate" => (Vec::new(), path[1..].to_vec()),
        "self" => (from.to_vec(), path[1..].to_vec()),
        "super" => (from[..from.len().checked_sub(ups)?].to_vec(), path[ups..].to_vec()),
        _ if codes.contains_key(&joined(from, first)) => (from.to_vec(), path.to_vec()),
        _ => return None,
    })
}

/// Reads a module and its declared submodules.
fn read_module(source: &Path, module: ModulePath, codes: &mut BTreeMap<ModulePath, String>) {
    let place = module.iter().fold(source.to_owned(), |place, name| place.join(name));
    let text = fs::read_to_string(place.with_extension("rs")).or_else(|_| fs::read_to_string(place.join("mod.rs")));
    let text = text.or_else(|_| fs::read_to_string(place.join("lib.rs")));
    let code = without_tests(&without_comments(&text.unwrap_or_else(|error| panic!("{}: {error}", place.display()))));
    for line in code.lines().map(str::trim) {
        let declared = line.strip_suffix(';').and_then(|line| line.rsplit_once("mod "));
        if let Some((visibility, name)) = declared
            && (visibility.is_empty() || visibility.starts_with("pub"))
        {
            read_module(source, joined(&module, name), codes);
        }
    }
    codes.insert(module, code);
}

fn without_comments(text: &str) -> String {
    let code = |line: &str| match line.trim_start().starts_with("//") {
        true => String::new(),
        false => line.split(" // ").next().unwrap_or_default().to_owned(),
    };
    text.lines().map(code).collect::<Vec<_>>().join("\n")
}

/// The text without code for tests. The indentation of rustfmt shows where an item ends.
fn without_tests(text: &str) -> String {
    let (mut kept, mut lines) = (Vec::new(), text.lines());
    while let Some(line) = lines.next() {
        if !line.trim_start().starts_with("#[cfg(test)]") {
            kept.push(line);
            continue;
        }
        let indent = &line[..line.len() - line.trim_start().len()];
        let head = lines.find(|line| !line.trim_start().starts_with("#["));
        if head.is_some_and(|head| head.ends_with('{')) {
            let ends = [format!("{indent}}}"), format!("{indent}}};")];
            lines.find(|line| ends.iter().any(|end| line == end));
        }
    }
    kept.join("\n")
}

/// All paths of a text: those of its `use` statements and those inside expressions.
fn paths_in(code: &str) -> Vec<NamedPath> {
    let (mut named, mut rest) = (Vec::new(), String::new());
    for statement in code.split_inclusive([';', '\n']).fold(Vec::<String>::new(), gathered) {
        let trimmed = statement.trim();
        match use_of(trimmed) {
            Some((is_public, list)) => {
                named.extend(expanded(list).into_iter().map(|path| NamedPath { path, is_public }));
            }
            None => rest.push_str(&statement),
        }
    }
    named.extend(inline_paths(&rest).into_iter().map(|path| NamedPath { path, is_public: false }));
    named
}

/// Joins the lines of one `use` statement.
fn gathered(mut statements: Vec<String>, line: &str) -> Vec<String> {
    match statements.last_mut() {
        Some(last) if use_of(last.trim()).is_some() && !last.trim_end().ends_with(';') => last.push_str(line),
        _ => statements.push(line.to_owned()),
    }
    statements
}

/// Whether a `use` statement re-exports, and the path that it names.
fn use_of(statement: &str) -> Option<(bool, &str)> {
    let (before, list) = match statement.strip_prefix("use ") {
        Some(list) => ("", list),
        None => statement.split_once(" use ")?,
    };
    (before.is_empty() || (before.starts_with("pub") && !before.contains(char::is_whitespace)))
        .then(|| (!before.is_empty(), list.trim_end_matches(';')))
}

/// The paths of a list: `a::{b, c::{d, e}}` becomes `a::b`, `a::c::d`, `a::c::e`.
fn expanded(list: &str) -> Vec<Vec<String>> {
    let list = list.trim();
    if let Some((head, inner)) = list.split_once('{') {
        let head: Vec<String> = names(head);
        let inner = inner.trim_end().strip_suffix('}').unwrap_or(inner);
        let each = split_at_commas(inner).into_iter().flat_map(expanded);
        return each.map(|path| [head.as_slice(), path.as_slice()].concat()).collect();
    }
    let path = names(list.split(" as ").next().unwrap_or_default());
    if path.is_empty() { Vec::new() } else { vec![path] }
}

fn names(path: &str) -> Vec<String> {
    path.split("::").map(str::trim).filter(|name| !name.is_empty() && *name != "self").map(str::to_owned).collect()
}

fn split_at_commas(list: &str) -> Vec<&str> {
    let (mut depth, mut start, mut parts) = (0, 0, Vec::new());
    for (at, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&list[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&list[start..]);
    parts
}

/// Paths of two names or more in code.
fn inline_paths(code: &str) -> Vec<Vec<String>> {
    let is_of_path = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let paths = code.split(|c| !is_of_path(c)).filter(|path| path.contains("::") && !path.starts_with("::"));
    paths.map(|path| path.split("::").filter(|name| !name.is_empty()).map(str::to_owned).collect()).collect()
}
