//! How low the search gets: our own method beside the published one, component by component, from 20 to 1,000 copies.
//!
//! `cargo bench --bench heights` measures everything on the project's own parts and writes `docs/benchmark.md`; `--
//! --help` shows how to measure a part of it. `cargo test --bench heights -- --gate` is the short run before every
//! merge.
#![allow(clippy::print_stdout)] // a bench prints its measurements

mod cases;
#[path = "../common/cpu_time.rs"]
mod cpu_time;
mod gate;
mod kernel;
#[path = "../common/memory.rs"]
mod memory;
mod page;
#[path = "../common/pairs.rs"]
mod pairs;
mod plan;
mod plot;
mod record_book;
mod runner;
#[path = "../common/statistics.rs"]
mod statistics;
mod tables;
mod trial;

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Parser;

use plan::BenchSection;
use record_book::{MeasurementOrigin, RecordBook};
use trial::SearchTrial;

/// Measures how low the search gets and writes docs/benchmark.md.
#[derive(Debug, Parser)]
struct BenchArgs {
    /// What to measure, e.g. heights,ablation; `data` needs NESTD_DATA [default: everything but data]
    #[arg(long, value_delimiter = ',', value_enum)]
    only: Vec<BenchSection>,
    /// Only these workloads, e.g. fans20,engine30, or data/fan20 with `--only data`
    #[arg(long, value_delimiter = ',')]
    cases: Vec<String>,
    /// CPU seconds of each search
    #[arg(long, value_delimiter = ',', default_value = "10,60")]
    secs: Vec<u64>,
    /// Seeds of each search, from 1
    #[arg(long, default_value_t = 3)]
    seeds: u64,
    /// Leave out the published method
    #[arg(long)]
    ours: bool,
    /// Evaluations of each search in the ablation
    #[arg(long, default_value_t = 300_000)]
    evaluations: u64,
    /// Threads of our own search; CPU seconds are those of all of them
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Searches at the same time
    #[arg(long, default_value_t = 2)]
    jobs: usize,
    /// Leave out measurements that exist for this commit
    #[arg(long)]
    resume: bool,
    /// Measure nothing, write the page again
    #[arg(long)]
    page: bool,
    /// Compare heights at fixed evaluations with benches/baseline.toml; fails when they are worse by more than 2 %
    #[arg(long)]
    gate: bool,
    /// Measure as the gate does and write a new benches/baseline.toml
    #[arg(long)]
    update: bool,
    /// Run one search, given as JSON: the bench starts this for each search
    #[arg(long, hide = true)]
    trial: Option<String>,
    /// Passed by `cargo bench`
    #[arg(long, hide = true)]
    bench: bool,
}

/// A file of the repository.
fn repository(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(file)
}

fn main() -> Result<()> {
    let args = BenchArgs::parse();
    if let Some(text) = &args.trial {
        let trial: SearchTrial = serde_json::from_str(text)?;
        println!("{}", serde_json::to_string(&trial.run()?)?);
        return Ok(());
    }
    if args.gate || args.update {
        return gate::run(args.jobs, args.update);
    }
    if !args.bench {
        println!("heights: measures with `cargo bench --bench heights`, guards with `-- --gate`");
        return Ok(());
    }
    measure(&args)
}

fn measure(args: &BenchArgs) -> Result<()> {
    let mut book = RecordBook::read()?;
    let origin = MeasurementOrigin::here();
    if !args.page {
        let plan = plan::plan(args)?;
        let known = |trial: &SearchTrial| {
            args.resume && book.find_record(trial).is_some_and(|r| r.origin.commit == origin.commit)
        };
        let left: Vec<SearchTrial> = plan.into_iter().filter(|trial| !known(trial)).collect();
        runner::run_trials(left, args.jobs, |finding| {
            println!("{}", finding.line());
            book.add_finding(finding, &origin);
            book.write()
        })?;
        if plan::asks_for(args, BenchSection::Kernel) {
            book.kernel = kernel::measured(&origin);
            book.write()?;
        }
    }
    page::write(&book)
}
