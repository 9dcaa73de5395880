//! Builds the tests, finds out which test reaches which mutant, and tries each mutant.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
    time::{Duration, Instant},
};

use anyhow::{Context, Result, ensure};

use crate::{chosen::Chosen, mutate::Mutator};

/// A mutant that makes a test last longer than this, and than many times its usual time, is noticed.
const LONGEST: Duration = Duration::from_secs(60);
/// How many tests of a mutant run in one process, quick ones first.
const TESTS_AT_ONCE: usize = 8;
/// Tests of a mutant that are run at most, quick ones first.
const MOST_TESTS: usize = 120;

/// What building has brought.
pub enum Built {
    /// The test program.
    Program(PathBuf),
    /// The mutants near which the compiler found errors.
    Refused(BTreeSet<u32>),
}

/// Builds the tests of a package's library.
pub fn build(tree: &Path, package: &str) -> Result<Built> {
    let mut cargo = Command::new("cargo");
    cargo.args(["test", "--no-run", "--lib", "--message-format=json", "-p", package]).current_dir(tree);
    let output = cargo.stderr(Stdio::null()).output().context("starting cargo")?;
    let (mut program, mut refused) = (None, BTreeSet::new());
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        let Ok(message) = serde_json::from_str::<serde_json::Value>(line) else { continue };
        if message["reason"] == "compiler-artifact" && message["profile"]["test"] == true {
            program = message["executable"].as_str().map(PathBuf::from).or(program);
        }
        if message["reason"] == "compiler-message" && message["message"]["level"] == "error" {
            eprintln!("left out: {}", message["message"]["message"].as_str().unwrap_or_default());
            refused.extend(mutants_of(tree, &message["message"]));
        }
    }
    match program {
        Some(program) if output.status.success() => Ok(Built::Program(program)),
        _ => Ok(Built::Refused(refused)),
    }
}

/// Builds the tests of all libraries. Returns the test program of each package.
pub fn build_all(tree: &Path) -> Result<BTreeMap<String, PathBuf>> {
    let mut cargo = Command::new("cargo");
    cargo.args(["test", "--no-run", "--lib", "--message-format=json"]).current_dir(tree);
    let output = cargo.stderr(Stdio::null()).output().context("starting cargo")?;
    let mut programs = BTreeMap::new();
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        let Ok(message) = serde_json::from_str::<serde_json::Value>(line) else { continue };
        if message["message"]["level"] == "error" {
            eprintln!("{}", message["message"]["rendered"].as_str().unwrap_or_default());
        }
        if let (Some(name), Some(program)) = (message["target"]["name"].as_str(), message["executable"].as_str())
            && message["profile"]["test"] == true
        {
            programs.insert(name.replace('_', "-"), PathBuf::from(program));
        }
    }
    ensure!(output.status.success(), "the tree does not compile");
    Ok(programs)
}

/// Tries the chosen mutants, and prints one line for each.
pub fn try_chosen(tree: &Path, programs: &BTreeMap<String, PathBuf>, all: &[Chosen], only: &[String]) -> Result<()> {
    let program = |package: &String| programs.get(package).with_context(|| format!("no package {package}"));
    let mut usual: BTreeMap<&(String, Vec<String>), Duration> = BTreeMap::new();
    let asked: Vec<(u32, &Chosen)> = (1..)
        .zip(all)
        .filter(|(_, mutant)| only.is_empty() || only.iter().any(|word| mutant.what.contains(word)))
        .collect();
    for (_, mutant) in &asked {
        let (package, names) = &mutant.tests;
        if usual.contains_key(&mutant.tests) {
            continue;
        }
        let began = Instant::now();
        let output = Command::new(program(package)?).args(names).current_dir(root_of(tree, package)).output()?;
        let told = String::from_utf8_lossy(&output.stdout);
        ensure!(!told.contains("running 0 tests"), "no test of {package} is named {names:?}");
        ensure!(output.status.success(), "without a mutant, tests of {package} named {names:?} fail: {told}");
        usual.insert(&mutant.tests, began.elapsed());
    }
    let mut survivors = 0;
    for (number, mutant) in &asked {
        let (package, names) = &mutant.tests;
        let mut test = Command::new(program(package)?);
        test.args(names).current_dir(root_of(tree, package));
        test.env("NESTD_MUTANT", number.to_string()).env("RUST_BACKTRACE", "0");
        let mut child = test.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn()?;
        let survives = wait(&mut child, LONGEST + 10 * usual[&mutant.tests]);
        survivors += u32::from(survives);
        println!("{} {}: {}", if survives { "survives" } else { "killed  " }, mutant.file, mutant.what);
    }
    println!("{} chosen mutants, {survivors} survive", asked.len());
    Ok(())
}

fn root_of(tree: &Path, package: &str) -> PathBuf {
    if package == "nestd" { tree.to_owned() } else { tree.join("crates").join(package) }
}

/// The numbers that stand in the lines of an error, or in the nearest lines above them.
fn mutants_of(tree: &Path, message: &serde_json::Value) -> BTreeSet<u32> {
    let mut found = BTreeSet::new();
    for span in message["spans"].as_array().into_iter().flatten() {
        let Some(file) = span["file_name"].as_str() else { continue };
        let Ok(text) = fs::read_to_string(tree.join(file)) else { continue };
        let lines: Vec<&str> = text.lines().collect();
        let first = span["line_start"].as_u64().unwrap_or(1) as usize;
        let last = span["line_end"].as_u64().unwrap_or(1) as usize;
        let within: BTreeSet<u32> = lines.iter().take(last).skip(first - 1).flat_map(|line| numbers_in(line)).collect();
        match within.is_empty() {
            false => found.extend(within),
            true => found.extend(lines.iter().take(first - 1).rev().find_map(|line| numbers_in(line).next_back())),
        }
    }
    found
}

fn numbers_in(line: &str) -> impl DoubleEndedIterator<Item = u32> {
    let numbers: Vec<u32> = line
        .split("is_on(")
        .skip(1)
        .filter_map(|rest| rest.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok())
        .collect();
    numbers.into_iter()
}

/// A test: its name, what it reaches, and its time.
struct Traced {
    name: String,
    reaches: BTreeSet<u32>,
    takes: Duration,
}

/// Tries all mutants and prints the survivors.
pub fn try_all(tree: &Path, program: &Path, mutator: &Mutator, only: &[String]) -> Result<()> {
    let listed = Command::new(program).args(["--list", "--format", "terse"]).current_dir(tree).output()?;
    let names: Vec<String> = (String::from_utf8_lossy(&listed.stdout).lines())
        .filter_map(|line| line.strip_suffix(": test").map(str::to_owned))
        .filter(|name| only.is_empty() || only.iter().any(|part| name.contains(part)))
        .collect();
    eprintln!("{} tests are traced", names.len());
    let traced = in_parallel(&names, |name| trace(tree, program, name)).into_iter().flatten().collect::<Vec<_>>();
    let mut reached_by: BTreeMap<u32, Vec<&Traced>> = BTreeMap::new();
    for test in &traced {
        test.reaches.iter().for_each(|&number| reached_by.entry(number).or_default().push(test));
    }
    reached_by.values_mut().for_each(|tests| tests.sort_by_key(|test| test.takes));
    let numbers: Vec<u32> = mutator.mutants.keys().copied().collect();
    eprintln!("{} of {} mutants are reached", reached_by.len(), numbers.len());
    let killed = in_parallel(&numbers, |number| {
        let tests = reached_by.get(number).map(Vec::as_slice).unwrap_or_default();
        (tests[..tests.len().min(MOST_TESTS)]).chunks(TESTS_AT_ONCE).any(|tests| fails(tree, program, tests, *number))
    });
    let mut survivors = 0;
    for (number, _) in numbers.iter().zip(&killed).filter(|(_, killed)| !**killed) {
        survivors += 1;
        let (mutant, tests) = (&mutator.mutants[number], reached_by.get(number).map_or(0, Vec::len));
        println!("survives {}:{} {} ({tests} tests reach it)", mutant.file, mutant.line, mutant.what);
    }
    println!("{} mutants, {} killed, {survivors} survive", numbers.len(), numbers.len() - survivors);
    Ok(())
}

/// Applies `work` to all on as many threads as there are cores; the results are in order.
fn in_parallel<T: Sync, R: Send>(all: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let (next, results) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                loop {
                    let at = next.fetch_add(1, Ordering::Relaxed);
                    let Some(item) = all.get(at) else { return };
                    let result = work(item);
                    results.lock().unwrap_or_else(PoisonError::into_inner).push((at, result));
                }
            });
        }
    });
    let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.sort_by_key(|(at, _)| *at);
    results.into_iter().map(|(_, result)| result).collect()
}

fn trace(tree: &Path, program: &Path, name: &str) -> Option<Traced> {
    let file = std::env::temp_dir().join(format!("nestd-mutants-trace-{}-{:x}", std::process::id(), fold(name)));
    let began = Instant::now();
    let mut child = spawn(tree, program, &[name], 0, Some(&file))?;
    let passed = wait(&mut child, 3 * LONGEST);
    let told = fs::read_to_string(&file).unwrap_or_default();
    let _ = fs::remove_file(&file);
    if !passed {
        eprintln!("left out, for it fails without a mutant: {name}");
        return None;
    }
    let reaches = told.lines().filter_map(|line| line.parse().ok()).collect();
    Some(Traced { name: name.to_owned(), reaches, takes: began.elapsed() })
}

fn fails(tree: &Path, program: &Path, tests: &[&Traced], number: u32) -> bool {
    let names: Vec<&str> = tests.iter().map(|test| test.name.as_str()).collect();
    let usual: Duration = tests.iter().map(|test| test.takes).sum();
    spawn(tree, program, &names, number, None).is_some_and(|mut child| !wait(&mut child, LONGEST + 10 * usual))
}

fn spawn(tree: &Path, program: &Path, names: &[&str], number: u32, trace: Option<&Path>) -> Option<Child> {
    let mut test = Command::new(program);
    test.args(names).args(["--exact", "--test-threads", "2"]).current_dir(tree);
    test.env("NESTD_MUTANT", number.to_string()).env("RUST_BACKTRACE", "0");
    if let Some(trace) = trace {
        test.env("NESTD_MUTANT_TRACE", trace);
    }
    test.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().ok()
}

/// Whether a test program ends well and in time.
fn wait(child: &mut Child, longest: Duration) -> bool {
    let began = Instant::now();
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return status.success(),
            Ok(None) if began.elapsed() < longest => thread::sleep(Duration::from_millis(10)),
            _ => {
                let _ = child.kill();
                let _ = child.wait();
                return false;
            }
        }
    }
}

/// A short number of a text, for the name of a file.
fn fold(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |sum, byte| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}
