//! The short run that guards every merge: heights at fixed evaluations against `benches/baseline.toml`.
//!
//! The same seed, lanes and evaluations give the same build, so the speed of the machine has no influence. A single
//! search says little, because any change of the code moves its height by some percent. So only the mean over all
//! searches counts.

use std::collections::BTreeMap;

use anyhow::{Context, Result, ensure};
use nester::NestingMethod;
use serde::{Deserialize, Serialize};

use super::{
    repository, runner,
    trial::{SearchTrial, TrialBudget},
};

const FILE: &str = "benches/baseline.toml";
/// Workloads, their evaluations and their number of seeds.
const SEARCHES: [(&str, u64, u64); 3] = [("fans20", 400_000, 2), ("engine30", 120_000, 4), ("small60", 120_000, 4)];
/// Relative change by which the mean may be worse.
const TOLERANCE: f64 = 0.02;
/// An improvement of at least this size should become the new baseline.
const WORTH_KEEPING: f64 = 0.01;

const HEAD: &str = "\
# Build heights in mm at fixed evaluations, one per seed from 1, as the gate of `.ci/run` expects them. It fails when their
# mean gets worse by more than 2 %. After a change that makes builds lower (or that is worth a greater height), write
# new values:  cargo bench --bench heights -- --update

";

/// The heights that a workload reached.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct ReachedHeights {
    evaluations: u64,
    heights_mm: Vec<f64>,
}

/// Measures, and compares with the baseline or writes it.
pub fn run(jobs: usize, update: bool) -> Result<()> {
    let reached = measure(jobs)?;
    if update {
        let text = format!("{HEAD}{}", toml::to_string(&reached)?);
        println!("writing {FILE}");
        return std::fs::write(repository(FILE), text).with_context(|| format!("writing {FILE}"));
    }
    let text = std::fs::read_to_string(repository(FILE)).with_context(|| format!("reading {FILE}"))?;
    let baseline: BTreeMap<String, ReachedHeights> =
        toml::from_str(&text).with_context(|| format!("reading {FILE}"))?;
    let change = compare(&baseline, &reached)?;
    println!("mean of all: {:+.2} %", 100.0 * change);
    ensure!(change <= TOLERANCE, "heights at fixed evaluations got worse by {:.1} %", 100.0 * change);
    if change < -WORTH_KEEPING {
        println!("builds got lower: write it down with `cargo bench --bench heights -- --update`");
    }
    Ok(())
}

/// The mean relative change of height over all searches; one line for each workload.
fn compare(baseline: &BTreeMap<String, ReachedHeights>, reached: &BTreeMap<String, ReachedHeights>) -> Result<f64> {
    let mut ratios = Vec::new();
    for (case, now) in reached {
        let before = baseline.get(case).with_context(|| format!("{FILE} does not know {case}: use --update"))?;
        let same = before.evaluations == now.evaluations && before.heights_mm.len() == now.heights_mm.len();
        ensure!(same, "{FILE} holds other searches of {case}: use --update");
        let of_case: Vec<f64> =
            now.heights_mm.iter().zip(&before.heights_mm).map(|(now, before)| now / before).collect();
        let (mean_now, mean_before) = (mean(&now.heights_mm), mean(&before.heights_mm));
        println!("{case}: {mean_now:.2} mm, was {mean_before:.2} mm ({:+.2} %)", 100.0 * (mean(&of_case) - 1.0));
        ratios.extend(of_case);
    }
    Ok(mean(&ratios) - 1.0)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn measure(jobs: usize) -> Result<BTreeMap<String, ReachedHeights>> {
    let trial = |case: &str, evaluations: u64, seed: u64| SearchTrial {
        case: case.to_owned(),
        method: NestingMethod::Nestd,
        without: None,
        budget: TrialBudget::Evaluations(evaluations),
        seed,
        threads: 1,
    };
    let trials = SEARCHES
        .iter()
        .flat_map(|&(case, evaluations, seeds)| (1..=seeds).map(move |seed| trial(case, evaluations, seed)));
    let mut reached: BTreeMap<String, ReachedHeights> = (SEARCHES.iter())
        .map(|&(case, evaluations, seeds)| {
            (case.to_owned(), ReachedHeights { evaluations, heights_mm: vec![0.0; seeds as usize] })
        })
        .collect();
    runner::run_trials(trials.collect(), jobs, |finding| {
        ensure!(finding.unplaced == 0, "{}: a copy found no place", finding.trial.case);
        println!("{}", finding.line());
        if let Some(case) = reached.get_mut(&finding.trial.case) {
            case.heights_mm[finding.trial.seed as usize - 1] = finding.height_mm;
        }
        Ok(())
    })?;
    Ok(reached)
}
