//! One search to measure, and its result.

use std::sync::Mutex;

use anyhow::{Result, bail, ensure};
use nester::{
    NestingConfig, NestingInstance, NestingMethod, NestingSolution, PlacedSolid, SearchComponents, StopCondition,
    lower_bound_mm, nest, prove_placed_solids,
};
use serde::{Deserialize, Serialize};
use solids::Pose;

use super::{cases, cpu_time::cpu_secs, memory::status_mib};

/// What ends a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TrialBudget {
    /// CPU seconds of all threads.
    CpuSecs(u64),
    /// Evaluations; the same placements on every run.
    Evaluations(u64),
}

/// One search: everything that determines its result, except the machine and the code.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SearchTrial {
    /// Name of the workload.
    pub case: String,
    /// Which search.
    pub method: NestingMethod,
    /// The component that is disabled.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub without: Option<String>,
    /// What ends it.
    pub budget: TrialBudget,
    /// Seed of every random choice.
    pub seed: u64,
    /// Threads.
    pub threads: usize,
}

/// One step down: CPU seconds, evaluations, mm.
pub type CurveStep = (f64, u64, f64);

/// The result of a search; its last layout was proved on its triangles.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SearchFinding {
    /// The search.
    #[serde(flatten)]
    pub trial: SearchTrial,
    /// Build height, mm.
    pub height_mm: f64,
    /// Lower bound of the height of any layout, mm.
    pub lower_bound_mm: f64,
    /// Copies asked for.
    pub copies: usize,
    /// Copies that found no place.
    pub unplaced: usize,
    /// Different meshes.
    pub meshes: usize,
    /// Triangles of the different meshes.
    pub triangles: usize,
    /// Evaluations made.
    pub evaluations: u64,
    /// CPU seconds of all threads.
    pub cpu_secs: f64,
    /// Peak memory of the process, MiB.
    pub peak_mib: f64,
    /// Every lower layout of all copies; the first one is the first valid build.
    pub curve: Vec<CurveStep>,
}

impl SearchFinding {
    /// CPU seconds until the first layout of all copies.
    pub fn first_secs(&self) -> Option<f64> {
        self.curve.first().map(|step| step.0)
    }

    /// One line for the terminal.
    pub fn line(&self) -> String {
        let SearchTrial { case, method, without, budget, seed, .. } = &self.trial;
        let without = without.as_ref().map_or_else(String::new, |component| format!(" without {component}"));
        let first = self.first_secs().map_or_else(|| "no whole layout".to_owned(), |s| format!("first at {s:.2} s"));
        format!(
            "{case} {method:?}{without} {budget:?} seed {seed}: {:.2} mm, {} unplaced, {first}, {} evaluations in {:.1} s, {:.0} MiB",
            self.height_mm, self.unplaced, self.evaluations, self.cpu_secs, self.peak_mib
        )
    }
}

impl SearchTrial {
    /// Runs the search, and proves its last layout.
    pub fn run(&self) -> Result<SearchFinding> {
        let instance = cases::instance(&self.case)?;
        let config = NestingConfig {
            method: self.method,
            seed: self.seed,
            threads: self.threads,
            components: self.components()?,
            ..NestingConfig::default()
        };
        let meter = BudgetMeter { began_secs: cpu_secs(), budget: self.budget };
        let curve = Mutex::new(Vec::<CurveStep>::new());
        let solution = nest(&instance, &config, &[], &meter, &mut |found: &NestingSolution, evaluations: u64| {
            if found.unplaced.is_empty() {
                let step = (rounded(meter.secs()), evaluations, rounded(found.height_mm));
                curve.lock().expect("nobody panics with it").push(step);
            }
        });
        let cpu_secs = rounded(meter.secs());
        assert_proved(&instance, &solution)?;
        let meshes = cases::distinct(&instance);
        Ok(SearchFinding {
            trial: self.clone(),
            height_mm: rounded(solution.height_mm),
            lower_bound_mm: rounded(lower_bound_mm(&instance)),
            copies: instance.copy_count(),
            unplaced: solution.unplaced.len(),
            meshes: meshes.len(),
            triangles: meshes.iter().map(|mesh| mesh.triangles().len()).sum(),
            evaluations: solution.evaluations,
            cpu_secs,
            peak_mib: status_mib("VmHWM:").round(),
            curve: thinned(curve.into_inner().expect("nobody panics with it")),
        })
    }

    fn components(&self) -> Result<SearchComponents> {
        let Some(name) = &self.without else { return Ok(SearchComponents::default()) };
        match SearchComponents::each_disabled().into_iter().find(|(component, _)| component == name) {
            Some((_, components)) => Ok(components),
            None => bail!("there is no component {name:?}"),
        }
    }
}

/// The budget in the form that the search queries.
struct BudgetMeter {
    began_secs: f64,
    budget: TrialBudget,
}

impl BudgetMeter {
    fn secs(&self) -> f64 {
        cpu_secs() - self.began_secs
    }
}

impl StopCondition for BudgetMeter {
    fn spent_share_at(&self, evaluations: u64) -> f64 {
        match self.budget {
            TrialBudget::CpuSecs(limit) => self.secs() / limit as f64,
            TrialBudget::Evaluations(limit) => evaluations as f64 / limit as f64,
        }
    }
}

/// Rounds to hundredths, which is precise enough for a record.
fn rounded(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

/// Removes steps of less than a thousandth of the height, so that records stay small; keeps the first and the last.
fn thinned(curve: Vec<CurveStep>) -> Vec<CurveStep> {
    let mut kept: Vec<CurveStep> = Vec::new();
    for (at, &step) in curve.iter().enumerate() {
        if at + 1 == curve.len() || kept.last().is_none_or(|last| step.2 < 0.999 * last.2) {
            kept.push(step);
        }
    }
    kept
}

/// Asserts that the independent judge finds no fault; only then does a height count.
fn assert_proved(instance: &NestingInstance, solution: &NestingSolution) -> Result<()> {
    let body = |item: usize, copy: u32, pose: Pose| PlacedSolid {
        name: format!("{} #{copy}", instance.items()[item].name),
        mesh: instance.items()[item].mesh.clone(),
        pose,
        clearance_mm: instance.clearance_between_mm(item, item),
    };
    let bodies: Vec<PlacedSolid> = solution.placements.iter().map(|p| body(p.item, p.copy, p.pose)).collect();
    let proof = prove_placed_solids(&bodies, instance.volume().size_mm);
    ensure!(proof.is_proved(), "the layout is not proved: {proof:?}");
    ensure!((proof.height_mm - solution.height_mm).abs() < 1e-6, "the height is not what was told");
    Ok(())
}
