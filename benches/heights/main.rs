//! How low the search gets: our own method beside the published one, organ by organ, from 20 to 1,000 copies.
//!
//! `cargo bench --bench heights` measures everything on the project's own parts and writes `docs/benchmark.md`; `-- --help`
//! tells how to measure a part of it. `cargo test --bench heights -- --gate` is the short run that guards every merge.
#![allow(clippy::print_stdout)] // a bench tells what it measures

mod book;
mod cases;
mod crew;
mod gate;
mod kernel;
mod page;
#[path = "../common/pairs.rs"]
mod pairs;
mod plan;
mod plot;
mod tables;
mod trial;

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Parser;

use book::{Book, Origin};
use plan::Section;
use trial::Trial;

/// Measures how low the search gets and writes docs/benchmark.md.
#[derive(Debug, Parser)]
struct Args {
    /// What to measure, e.g. heights,ablation; `data` needs NESTD_DATA [default: everything but data]
    #[arg(long, value_delimiter = ',', value_enum)]
    only: Vec<Section>,
    /// Only these workloads, e.g. fans20,engine30
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
    /// Leave out what has been measured at this commit already
    #[arg(long)]
    resume: bool,
    /// Measure nothing, write the page anew
    #[arg(long)]
    page: bool,
    /// Compare heights at fixed evaluations with benches/baseline.toml; fails when they are worse by more than 2 %
    #[arg(long)]
    gate: bool,
    /// Measure as the gate does and write benches/baseline.toml anew
    #[arg(long)]
    update: bool,
    /// One search, told as JSON: what the bench starts for each of its searches
    #[arg(long, hide = true)]
    trial: Option<String>,
    /// Said by `cargo bench`
    #[arg(long, hide = true)]
    bench: bool,
}

/// A file of the repository.
fn repository(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(file)
}

fn main() -> Result<()> {
    let args = Args::parse();
    if let Some(text) = &args.trial {
        let trial: Trial = serde_json::from_str(text)?;
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

fn measure(args: &Args) -> Result<()> {
    let mut book = Book::read()?;
    let origin = Origin::here();
    if !args.page {
        let plan = plan::plan(args)?;
        let known = |trial: &Trial| args.resume && book.finds(trial).is_some_and(|r| r.origin.commit == origin.commit);
        let left: Vec<Trial> = plan.into_iter().filter(|trial| !known(trial)).collect();
        crew::run(left, args.jobs, |finding| {
            println!("{}", finding.line());
            book.keep(finding, &origin);
            book.write()
        })?;
        if plan::asks_for(args, Section::Kernel) {
            book.kernel = kernel::measured(&origin);
            book.write()?;
        }
    }
    page::write(&book)
}
