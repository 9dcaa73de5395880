//! Mutants that people have chosen: what they change stands in `chosen.txt`, each with the tests that must notice it. They reach what no
//! operator of `mutate` does: a statement of SQL, a margin, a whole promise.

use std::{collections::BTreeMap, path::Path};

use anyhow::{Context, Result, bail, ensure};

/// A chosen mutant.
#[derive(Debug, Clone)]
pub struct Chosen {
    /// What is wrong with it, for people.
    pub what: String,
    /// The source file.
    pub file: String,
    /// The package whose tests must notice it, and what their names contain.
    pub tests: (String, Vec<String>),
    /// An expression, or a statement that ends in `;`. It stands once in the file.
    old: String,
    /// What stands instead; empty = a statement is left out.
    new: String,
}

/// Reads the table: blocks of a line `== WHAT`, a line `in FILE`, a line `by PACKAGE: NAMES`, a line `- OLD` and a line `+ NEW`. A line that
/// begins with blanks goes on with the one before.
pub fn read_table(text: &str) -> Result<Vec<Chosen>> {
    let (mut all, mut is_new): (Vec<Chosen>, bool) = (Vec::new(), false);
    for line in text.lines().filter(|line| !line.is_empty() && !line.starts_with('#')) {
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        if word == "==" {
            let (what, tests) = (rest.to_owned(), (String::new(), Vec::new()));
            all.push(Chosen { what, file: String::new(), tests, old: String::new(), new: String::new() });
            continue;
        }
        let mutant = all.last_mut().context("the table begins with a line `== WHAT`")?;
        match word {
            "in" => rest.clone_into(&mut mutant.file),
            "by" => {
                let (package, names) = rest.split_once(": ").with_context(|| line.to_owned())?;
                mutant.tests = (package.to_owned(), names.split_whitespace().map(str::to_owned).collect());
            }
            "-" => (is_new, mutant.old) = (false, rest.to_owned()),
            "+" => (is_new, mutant.new) = (true, rest.to_owned()),
            "" => {
                let text = if is_new { &mut mutant.new } else { &mut mutant.old };
                text.push('\n');
                text.push_str(line);
            }
            _ => bail!("the table has the line {line:?}"),
        }
    }
    Ok(all)
}

/// Writes all mutants into the files of a tree, each behind its number, from 1. Returns the roots of the crates that are concerned.
pub fn write_into(tree: &Path, all: &[Chosen]) -> Result<Vec<String>> {
    let mut by_file: BTreeMap<&str, BTreeMap<(usize, &str), Vec<usize>>> = BTreeMap::new();
    for (at, mutant) in all.iter().enumerate() {
        let source = std::fs::read_to_string(tree.join(&mutant.file)).with_context(|| mutant.file.clone())?;
        let found: Vec<usize> = source.match_indices(&mutant.old).map(|(start, _)| start).collect();
        ensure!(found.len() == 1, "{} has {:?} {} times ({})", mutant.file, mutant.old, found.len(), mutant.what);
        by_file.entry(&mutant.file).or_default().entry((found[0], &mutant.old)).or_default().push(at);
    }
    for (file, places) in &by_file {
        let mut source = std::fs::read_to_string(tree.join(file))?;
        let mut end = source.len();
        for (&(start, old), mutants) in places.iter().rev() {
            ensure!(start + old.len() <= end, "two mutants of {file} overlap at {old:?}");
            end = start;
            source.replace_range(start..start + old.len(), &switched(all, old, mutants));
        }
        std::fs::write(tree.join(file), source)?;
    }
    let mut roots: Vec<String> =
        by_file.keys().map(|file| file[..file.find("src/").unwrap_or(0) + 3].to_owned()).collect();
    roots.dedup();
    Ok(roots)
}

/// The text that stands in place of `old`.
fn switched(all: &[Chosen], old: &str, mutants: &[usize]) -> String {
    let is_statement = old.ends_with(';');
    let text = mutants.iter().fold(old.to_owned(), |text, &at| {
        format!("if crate::mutants::is_on({}) {{ {} }} else {{ {text} }}", at + 1, all[at].new)
    });
    if is_statement { text } else { format!("({text})") }
}
