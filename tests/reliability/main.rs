//! The reliability run: what a farm must survive, in the time that it is given, as one table. `cargo test` runs a few
//! seconds of each section; `cargo test --release --test reliability -- --minutes 60` runs all of it and writes
//! `docs/reliability.md`; `--only crash,kill` runs some.
#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test that cannot go on fails; this one is its own harness

mod asked;
mod big;
mod budget;
mod crash;
mod faults;
mod flood;
mod heavy;
mod hostile;
mod intake;
mod kill;
mod ledger;
mod life;
mod memory;
mod pair;
mod pool;
mod power;
mod restore;
mod rot;
mod row;
mod storm;
mod table;
mod torture;

#[path = "../support/mod.rs"]
mod support;

use std::{process::ExitCode, time::Instant};

use asked::Asked;
use budget::Budget;
use row::Row;
use support::{greedy, grid, trace};

/// A section: its name, its share of a long run, and what it does.
struct Section {
    name: &'static str,
    weight: f64,
    run: fn(&Budget) -> Row,
}

/// All sections, in the order of the table.
#[rustfmt::skip]
const SECTIONS: [Section; 15] = [
    Section { name: "crash", weight: 4.0, run: crash::run },
    Section { name: "faults", weight: 8.0, run: faults::run },
    Section { name: "power", weight: 5.0, run: power::run },
    Section { name: "kill", weight: 3.0, run: kill::run },
    Section { name: "storm", weight: 4.0, run: storm::run },
    Section { name: "pair", weight: 4.0, run: pair::run },
    Section { name: "restore", weight: 4.0, run: restore::run },
    Section { name: "hostile", weight: 2.0, run: hostile::run },
    Section { name: "torture", weight: 0.5, run: torture::run },
    Section { name: "heavy", weight: 2.0, run: heavy::run },
    Section { name: "flood", weight: 22.0, run: flood::run },
    Section { name: "intake", weight: 2.0, run: intake::run },
    Section { name: "rot", weight: 2.0, run: rot::run },
    Section { name: "memory", weight: 1.0, run: memory::run },
    Section { name: "ledger", weight: 3.0, run: ledger::run },
];

/// Wall seconds of a section in a short run.
const SHORT_SECS: f64 = 6.0;

fn main() -> ExitCode {
    let asked = Asked::from_args();
    let sections: Vec<&Section> = SECTIONS.iter().filter(|section| asked.wants(section.name)).collect();
    println!("\nrunning {} sections of the reliability run", sections.len());
    let all: f64 = sections.iter().map(|section| section.weight).sum();
    let mut rows = Vec::new();
    for section in sections {
        let budget = match asked.minutes {
            Some(minutes) => Budget::long(minutes * 60.0 * section.weight / all),
            None => Budget::short(SHORT_SECS),
        };
        let row = run(section, &budget);
        println!("section {} ... {}", section.name, if row.broken.is_empty() { "ok" } else { "BROKEN" });
        row.broken.iter().for_each(|sentence| println!("{}: {sentence}", row.section));
        rows.push(row);
    }
    let table = table::table(&rows);
    println!("\n{table}");
    if asked.is_whole() {
        table::write_document(&rows, asked.minutes.unwrap_or_default());
    }
    finish(&rows)
}

/// A section that panics has broken something, and keeps no other from its turn.
fn run(section: &Section, budget: &Budget) -> Row {
    let began = Instant::now();
    let row = pool::caught("the section ended with a panic", || (section.run)(budget));
    Row { section: section.name, seconds: began.elapsed().as_secs_f64(), ..row }
}

fn finish(rows: &[Row]) -> ExitCode {
    let failed = rows.iter().filter(|row| !row.broken.is_empty()).count();
    let word = if failed == 0 { "ok" } else { "FAILED" };
    println!(
        "test result: {word}. {} passed; {failed} failed; 0 ignored; 0 measured; 0 filtered out",
        rows.len() - failed
    );
    if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
