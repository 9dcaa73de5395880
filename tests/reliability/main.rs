//! The reliability run: failures that a farm must survive, tried within a given time, with the results as one table.
//! `cargo test` runs a few seconds of each section. `cargo test --release --test reliability -- --minutes 60` runs all
//! sections and writes `docs/reliability.md`; `--only crash,kill` runs some of them.
#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test that cannot continue fails; this test is its own harness

mod failures;
mod harness;
mod load;
mod people;
#[path = "../support/mod.rs"]
mod support;

use std::{process::ExitCode, time::Instant};

use harness::{SectionBudget, SectionResult, arguments::RunArguments, pool, table};

/// A section: its name, its share of a long run, and what it does.
struct ReliabilitySection {
    name: &'static str,
    weight: f64,
    run: fn(&SectionBudget) -> SectionResult,
}

/// All sections, in the order of the table.
#[rustfmt::skip]
const SECTIONS: &[ReliabilitySection] = &[
    ReliabilitySection { name: "crash", weight: 4.0, run: failures::crash::run },
    ReliabilitySection { name: "faults", weight: 8.0, run: failures::faults::run },
    ReliabilitySection { name: "power", weight: 5.0, run: failures::power::run },
    ReliabilitySection { name: "kill", weight: 3.0, run: failures::kill::run },
    ReliabilitySection { name: "storm", weight: 4.0, run: people::storm::run },
    ReliabilitySection { name: "orders", weight: 4.0, run: people::orders::run },
    ReliabilitySection { name: "bureau", weight: 3.0, run: people::bureau::run },
    ReliabilitySection { name: "told", weight: 2.0, run: people::told::run },
    ReliabilitySection { name: "door", weight: 3.0, run: people::door::run },
    ReliabilitySection { name: "refused", weight: 2.0, run: failures::refused::run },
    ReliabilitySection { name: "pair", weight: 4.0, run: failures::pair::run },
    ReliabilitySection { name: "again", weight: 3.0, run: people::again::run },
    ReliabilitySection { name: "restore", weight: 4.0, run: failures::restore::run },
    ReliabilitySection { name: "hostile", weight: 2.0, run: load::hostile::run },
    ReliabilitySection { name: "torture", weight: 0.5, run: load::torture::run },
    ReliabilitySection { name: "heavy", weight: 2.0, run: load::heavy::run },
    ReliabilitySection { name: "flood", weight: 22.0, run: load::flood::run },
    ReliabilitySection { name: "intake", weight: 2.0, run: load::intake::run },
    ReliabilitySection { name: "rot", weight: 2.0, run: failures::rot::run },
    ReliabilitySection { name: "memory", weight: 1.0, run: load::memory::run },
    ReliabilitySection { name: "ledger", weight: 3.0, run: load::ledger::run },
    ReliabilitySection { name: "nodes", weight: 6.0, run: failures::nodes::run },
];

/// Wall seconds of a section in a short run.
const SHORT_SECS: f64 = 6.0;

/// Wall seconds of a section in a short run beside others, where all is slower.
const SHORT_SECS_BESIDE_OTHERS: f64 = 12.0;

/// Sections whose rows hold times or memory, and the one whose servers have only seconds to see each other: nothing else runs
/// beside them.
const ALONE: &[&str] = &["pair", "hostile", "torture", "heavy", "flood", "intake", "memory", "ledger"];

fn main() -> ExitCode {
    let asked = RunArguments::from_args();
    let sections: Vec<&ReliabilitySection> = SECTIONS.iter().filter(|section| asked.wants(section.name)).collect();
    println!("\nrunning {} sections of the reliability run", sections.len());
    let rows = run_all(&sections, asked.minutes);
    let table = table::table(&rows);
    println!("\n{table}\n{}\n", SectionResult::sum(&rows).summary());
    if asked.is_whole() {
        table::write_document(&rows, asked.minutes.unwrap_or_default());
    }
    finish(&rows)
}

/// Runs the sections and returns their rows in the same order. In a short run, where a section mostly waits for its last
/// farm to end, others run beside it.
fn run_all(sections: &[&ReliabilitySection], minutes: Option<f64>) -> Vec<SectionResult> {
    let Some(minutes) = minutes else {
        let short = |section, secs| run(section, &SectionBudget::short(secs));
        let (alone, others): (Vec<_>, Vec<_>) =
            sections.iter().copied().partition(|section| ALONE.contains(&section.name));
        let mut rows = pool::in_parallel(others, &SectionBudget::short(f64::INFINITY), |section| {
            short(section, SHORT_SECS_BESIDE_OTHERS)
        });
        rows.extend(alone.into_iter().map(|section| short(section, SHORT_SECS)));
        rows.sort_by_key(|row| sections.iter().position(|section| section.name == row.section));
        return rows;
    };
    let all: f64 = sections.iter().map(|section| section.weight).sum();
    let budget = |weight: f64| SectionBudget::long(minutes * 60.0 * weight / all);
    sections.iter().map(|section| run(section, &budget(section.weight))).collect()
}

/// Runs a section and says how it ended. A panic counts as a violation and does not stop the other sections.
fn run(section: &ReliabilitySection, budget: &SectionBudget) -> SectionResult {
    let began = Instant::now();
    let row = pool::catch_panic("the section ended with a panic", || (section.run)(budget));
    println!("section {} ... {}", section.name, if row.broken.is_empty() { "ok" } else { "BROKEN" });
    row.broken.iter().for_each(|sentence| println!("{}: {sentence}", section.name));
    SectionResult { section: section.name, seconds: began.elapsed().as_secs_f64(), ..row }
}

fn finish(rows: &[SectionResult]) -> ExitCode {
    let failed = rows.iter().filter(|row| !row.broken.is_empty()).count();
    let word = if failed == 0 { "ok" } else { "FAILED" };
    println!(
        "test result: {word}. {} passed; {failed} failed; 0 ignored; 0 measured; 0 filtered out",
        rows.len() - failed
    );
    if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
