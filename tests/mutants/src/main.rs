//! Mutation tests: small faults are written into named source files, and each must make a test of the library fail. All mutants are
//! compiled at once, each behind a switch (`mutate`), so that hundreds are tried with one compilation.
//!
//!     cargo run --release --manifest-path tests/mutants/Cargo.toml -- --package delivery crates/delivery/src/queue/take_back.rs crates/ledger/src/words/put_back.rs
//!
//! Or chosen faults, `chosen.txt`, each with the tests that must notice it:
//!
//!     cargo run --release --manifest-path tests/mutants/Cargo.toml -- --chosen
//!
//! It works on a copy of the committed tree in `--tree` (default: a folder beside the target folder), runs each test once to see
//! which mutants it reaches, then runs the tests of each mutant until one fails. It prints the survivors, one a line, and a summary.
//! Tests that fail without a mutant are left out.

mod chosen;
mod mutate;
mod run;

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use anyhow::{Context, Result, bail};
use mutate::Mutator;

/// What is to be done.
struct Arguments {
    package: String,
    tree: PathBuf,
    only: Vec<String>,
    files: Vec<String>,
    chosen: bool,
}

fn main() -> Result<()> {
    let asked = arguments()?;
    copy_tree(&asked.tree)?;
    if asked.chosen {
        return try_chosen(&asked);
    }
    let sources: Vec<(String, String)> = (asked.files.iter())
        .map(|file| Ok((file.clone(), fs::read_to_string(asked.tree.join(file)).with_context(|| file.clone())?)))
        .collect::<Result<_>>()?;
    let root = match asked.package.as_str() {
        "nestd" => "src".to_owned(),
        other => format!("crates/{other}/src"),
    };
    add_switches(&asked.tree.join(&root))?;
    let mut mutator = Mutator::default();
    let program = loop {
        mutator.restart();
        for (file, source) in &sources {
            fs::write(asked.tree.join(file), mutator.mutate(file, source)?)?;
        }
        eprintln!("{} mutants, {} left out so far", mutator.mutants.len(), mutator.dropped.len());
        match run::build(&asked.tree, &asked.package)? {
            run::Built::Program(program) => break program,
            run::Built::Refused(numbers) if numbers.iter().any(|n| !mutator.dropped.contains(n)) => {
                mutator.dropped.extend(numbers)
            }
            run::Built::Refused(_) => bail!("the tree does not compile, and no mutant is the reason"),
        }
    };
    run::try_all(&asked.tree, &program, &mutator, &asked.only)
}

/// Tries the chosen mutants; with `--only`, those of which the text says one of its words.
fn try_chosen(asked: &Arguments) -> Result<()> {
    let all = chosen::read_table(&fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/chosen.txt"))?)?;
    for root in chosen::write_into(&asked.tree, &all)? {
        add_switches(&asked.tree.join(root))?;
    }
    run::try_chosen(&asked.tree, &run::build_all(&asked.tree)?, &all, &asked.only)
}

/// Gives a crate the switches of the mutants.
fn add_switches(root: &Path) -> Result<()> {
    let library = root.join("lib.rs");
    let text = fs::read_to_string(&library)?;
    fs::write(&library, format!("{text}\n/// The switches of the mutants.\npub mod mutants;\n"))?;
    Ok(fs::write(root.join("mutants.rs"), include_str!("switch.txt"))?)
}

fn arguments() -> Result<Arguments> {
    let mut asked = Arguments {
        package: "nestd".to_owned(),
        tree: std::env::temp_dir().join("nestd-mutants"),
        only: Vec::new(),
        files: Vec::new(),
        chosen: false,
    };
    let mut given = std::env::args().skip(1);
    while let Some(word) = given.next() {
        let mut value = || given.next().with_context(|| format!("{word} needs a value"));
        match word.as_str() {
            "--package" => asked.package = value()?,
            "--tree" => asked.tree = value()?.into(),
            "--only" => asked.only.extend(value()?.split(',').map(str::to_owned)),
            "--chosen" => asked.chosen = true,
            file => asked.files.push(file.to_owned()),
        }
    }
    if asked.files.is_empty() && !asked.chosen {
        bail!("name the source files that get mutants, for example crates/delivery/src/queue/take_back.rs");
    }
    Ok(asked)
}

/// Makes a copy of the committed tree, or brings an earlier one up to date.
fn copy_tree(tree: &Path) -> Result<()> {
    let git = |words: &[&str], at: &Path| Command::new("git").args(words).current_dir(at).output();
    if tree.exists() {
        let store = ["rev-parse", "--path-format=absolute", "--git-common-dir"];
        let (here, there) = (git(&store, Path::new("."))?, git(&store, tree)?);
        let head = git(&["rev-parse", "HEAD"], Path::new("."))?;
        let head = String::from_utf8_lossy(&head.stdout).trim().to_owned();
        if here.stdout != there.stdout
            || !git(&["checkout", "-q", "--force", "--detach", &head], tree)?.status.success()
        {
            bail!("{} is there already: remove it, or name another folder with --tree", tree.display());
        }
        return Ok(());
    }
    let made = Command::new("git").args(["worktree", "add", "--quiet", "--detach"]).arg(tree).status()?;
    if !made.success() {
        bail!("git could not make {}", tree.display());
    }
    Ok(())
}
