//! The lid probe: how much work the search needs to bring a saved layout below a lower lid. Each try continues the same
//! layout with another seed, so a change of the descent shows after a few minutes, where whole searches need hours.
//!
//! `cargo bench --bench lid_probe` probes some workloads; `-- --help` shows how to choose. The layouts are saved in a
//! folder: give the same one before and after a change.
#![allow(clippy::print_stdout)] // a bench prints its measurements

#[allow(dead_code)] // the heights bench needs more of it
#[path = "heights/cases.rs"]
mod cases;
#[path = "common/cpu_time.rs"]
mod cpu_time;
#[path = "common/statistics.rs"]
mod statistics;

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};
use clap::Parser;
use nester::{
    ItemPlacement, NestingConfig, NestingInstance, NestingSolution, PreparedMeshes, SearchBudget, nest, nest_with_cache,
};

use cpu_time::cpu_secs;
use statistics::{HALF_INTERVAL, mean_and_variance};

/// Measures the evaluations per lid that is reached, from saved layouts.
#[derive(Debug, Parser)]
struct ProbeArgs {
    /// Workloads, as `cargo bench --bench heights` names them
    #[arg(long, value_delimiter = ',', default_value = "engine30,organic88,cages42,twins120,bulk400")]
    cases: Vec<String>,
    /// Evaluations per copy after which a layout is saved: few give a high layout, many a low one
    #[arg(long, value_delimiter = ',', default_value = "1500,6000")]
    saved_after: Vec<u64>,
    /// Tries of each layout, each with a seed of its own
    #[arg(long, default_value_t = 40)]
    tries: u64,
    /// By how much the lid is lower than the layout, percent
    #[arg(long, default_value_t = 1.0)]
    lid: f64,
    /// Evaluations per copy after which a try has failed
    #[arg(long, default_value_t = 600)]
    most: u64,
    /// Folder of the saved layouts
    #[arg(long, default_value = "target/lid_probe")]
    layouts: PathBuf,
    /// Passed by `cargo bench`
    #[arg(long, hide = true)]
    bench: bool,
}

/// One try: whether the lid was reached, the evaluations made, and the height in the end, mm.
struct LidTry {
    is_reached: bool,
    evaluations: f64,
    height_mm: f64,
}

fn main() -> Result<()> {
    let args = ProbeArgs::parse();
    if !args.bench {
        println!("lid_probe: measures with `cargo bench --bench lid_probe`");
        return Ok(());
    }
    println!(
        "workload, saved after, height mm: reached of tries, evaluations per copy and lid reached, height reached mm, CPU s"
    );
    for case in &args.cases {
        let instance = cases::instance(case)?;
        for &effort in &args.saved_after {
            probe_layout(&args, case, &instance, effort)?;
        }
    }
    Ok(())
}

fn probe_layout(args: &ProbeArgs, case: &str, instance: &NestingInstance, effort: u64) -> Result<()> {
    let copies = instance.copy_count() as u64;
    let file = args.layouts.join(format!("{}-{effort}.json", case.replace('/', "-")));
    let (height_mm, start) = saved_layout(&file, instance, effort * copies)?;
    let lid_mm = height_mm * (1.0 - 0.01 * args.lid);
    let (prepared, began) = (PreparedMeshes::default(), cpu_secs());
    let tries: Vec<LidTry> =
        (1..=args.tries).map(|seed| try_lid(instance, &start, &prepared, (lid_mm, args.most * copies), seed)).collect();
    let reached = tries.iter().filter(|one| one.is_reached).count();
    let evaluations: Vec<f64> = tries.iter().map(|one| one.evaluations / copies as f64).collect();
    let heights: Vec<f64> = tries.iter().map(|one| one.height_mm).collect();
    let interval = |values: &[f64]| {
        let (mean, variance) = mean_and_variance(values);
        (mean, HALF_INTERVAL * variance.sqrt())
    };
    let ((spent, off), (height, height_off)) = (interval(&evaluations), interval(&heights));
    let each = args.tries as f64 / reached as f64;
    println!(
        "{case}, {effort}, {height_mm:.2}: {reached} of {}, {:.0} +- {:.0}, {height:.2} +- {height_off:.2}, {:.1}",
        args.tries,
        spent * each,
        off * each,
        cpu_secs() - began
    );
    Ok(())
}

/// The height and the placements of the layout in a file; searches for it and writes the file if there is none.
fn saved_layout(file: &Path, instance: &NestingInstance, evaluations: u64) -> Result<(f64, Vec<ItemPlacement>)> {
    if let Ok(bytes) = fs::read(file) {
        return serde_json::from_slice(&bytes).with_context(|| format!("reading {}", file.display()));
    }
    let found = nest(instance, &NestingConfig::default(), &[], &SearchBudget::of_evaluations(evaluations), &mut ());
    let saved = (found.height_mm, found.placements);
    fs::create_dir_all(file.parent().unwrap_or(Path::new(".")))?;
    fs::write(file, serde_json::to_vec(&saved)?).with_context(|| format!("writing {}", file.display()))?;
    Ok(saved)
}

/// Continues a layout until it is below the lid or `most` evaluations are made.
fn try_lid(
    instance: &NestingInstance,
    start: &[ItemPlacement],
    prepared: &PreparedMeshes,
    (lid_mm, most): (f64, u64),
    seed: u64,
) -> LidTry {
    let budget = SearchBudget::of_evaluations(most);
    let config = NestingConfig { seed, ..NestingConfig::default() };
    let found =
        nest_with_cache(instance, &config, start, prepared, &budget, &mut |better: &NestingSolution, _: u64| {
            if better.unplaced.is_empty() && better.height_mm <= lid_mm {
                budget.cancel();
            }
        });
    LidTry { is_reached: found.height_mm <= lid_mm, evaluations: found.evaluations as f64, height_mm: found.height_mm }
}
