//! One search to measure, and what was found.

use std::sync::Mutex;

use anyhow::{Result, bail, ensure};
use nester::{Body, Config, Instance, Method, Organs, Solution, Stop, lower_bound_mm, nest, prove};
use serde::{Deserialize, Serialize};
use solids::Pose;

use super::cases;

/// What ends a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Budget {
    /// CPU seconds of all threads.
    CpuSecs(u64),
    /// Evaluations; the same placements on every run.
    Evaluations(u64),
}

/// One search: all that decides its outcome but the machine and the code.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Trial {
    /// Name of the workload.
    pub case: String,
    /// Which search.
    pub method: Method,
    /// The organ that is taken out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub without: Option<String>,
    /// What ends it.
    pub budget: Budget,
    /// Seed of every random choice.
    pub seed: u64,
    /// Threads.
    pub threads: usize,
}

/// One step down: CPU seconds, evaluations, mm.
pub type Step = (f64, u64, f64);

/// What a search found; every layout told here was proved on its triangles.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Finding {
    /// The search.
    #[serde(flatten)]
    pub trial: Trial,
    /// Build height, mm.
    pub height_mm: f64,
    /// No layout can be lower, mm.
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
    /// Greatest memory of the process, MB.
    pub peak_mb: f64,
    /// Every lower layout of all copies; the first one is the first valid build.
    pub curve: Vec<Step>,
}

impl Finding {
    /// CPU seconds until the first layout of all copies.
    pub fn first_secs(&self) -> Option<f64> {
        self.curve.first().map(|step| step.0)
    }

    /// One line for the terminal.
    pub fn line(&self) -> String {
        let Trial { case, method, without, budget, seed, .. } = &self.trial;
        let without = without.as_ref().map_or_else(String::new, |organ| format!(" without {organ}"));
        let first = self.first_secs().map_or_else(|| "no whole layout".to_owned(), |s| format!("first at {s:.2} s"));
        format!(
            "{case} {method:?}{without} {budget:?} seed {seed}: {:.2} mm, {} unplaced, {first}, {} evaluations in {:.1} s, {:.0} MB",
            self.height_mm, self.unplaced, self.evaluations, self.cpu_secs, self.peak_mb
        )
    }
}

impl Trial {
    /// Searches, and proves what was found.
    pub fn run(&self) -> Result<Finding> {
        let instance = cases::instance(&self.case)?;
        let config = Config {
            method: self.method,
            seed: self.seed,
            threads: self.threads,
            organs: self.organs()?,
            ..Config::default()
        };
        let meter = Meter { began_secs: cpu_secs(), budget: self.budget };
        let curve = Mutex::new(Vec::<Step>::new());
        let solution = nest(&instance, &config, &[], &meter, &mut |found: &Solution, evaluations: u64| {
            if found.unplaced.is_empty() {
                let step = (rounded(meter.secs()), evaluations, rounded(found.height_mm));
                curve.lock().expect("nobody panics with it").push(step);
            }
        });
        let cpu_secs = rounded(meter.secs());
        assert_proved(&instance, &solution)?;
        let meshes = cases::distinct(&instance);
        Ok(Finding {
            trial: self.clone(),
            height_mm: rounded(solution.height_mm),
            lower_bound_mm: rounded(lower_bound_mm(&instance)),
            copies: instance.copies(),
            unplaced: solution.unplaced.len(),
            meshes: meshes.len(),
            triangles: meshes.iter().map(|mesh| mesh.triangles().len()).sum(),
            evaluations: solution.evaluations,
            cpu_secs,
            peak_mb: peak_mb().round(),
            curve: thinned(curve.into_inner().expect("nobody panics with it")),
        })
    }

    fn organs(&self) -> Result<Organs> {
        let Some(name) = &self.without else { return Ok(Organs::default()) };
        match Organs::each_taken_out().into_iter().find(|(organ, _)| organ == name) {
            Some((_, organs)) => Ok(organs),
            None => bail!("there is no organ {name:?}"),
        }
    }
}

/// The budget as the search asks for it.
struct Meter {
    began_secs: f64,
    budget: Budget,
}

impl Meter {
    fn secs(&self) -> f64 {
        cpu_secs() - self.began_secs
    }
}

impl Stop for Meter {
    fn spent(&self, evaluations: u64) -> f64 {
        match self.budget {
            Budget::CpuSecs(limit) => self.secs() / limit as f64,
            Budget::Evaluations(limit) => evaluations as f64 / limit as f64,
        }
    }
}

/// CPU seconds of this process so far: other work on the machine does not count.
pub fn cpu_secs() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Greatest resident memory of this process so far, MB; 0 where the system does not tell.
fn peak_mb() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|rest| rest.split_whitespace().next()?.parse::<f64>().ok()).map_or(0.0, |kb| kb / 1024.0)
}

/// A hundredth of a second or of a millimetre is enough in a record.
fn rounded(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

/// Leaves out steps of less than a thousandth of the height, so that records stay small; first and last stay.
fn thinned(curve: Vec<Step>) -> Vec<Step> {
    let mut kept: Vec<Step> = Vec::new();
    for (at, &step) in curve.iter().enumerate() {
        if at + 1 == curve.len() || kept.last().is_none_or(|last| step.2 < 0.999 * last.2) {
            kept.push(step);
        }
    }
    kept
}

/// A height counts only when the independent judge finds nothing.
fn assert_proved(instance: &Instance, solution: &Solution) -> Result<()> {
    let body = |item: usize, copy: u32, pose: Pose| Body {
        name: format!("{} #{copy}", instance.items()[item].name),
        mesh: instance.items()[item].mesh.clone(),
        pose,
        clearance_mm: instance.clearance_between_mm(item, item),
    };
    let bodies: Vec<Body> = solution.placements.iter().map(|p| body(p.item, p.copy, p.pose)).collect();
    let proof = prove(&bodies, instance.volume().size_mm);
    ensure!(proof.is_proved(), "the layout is not proved: {proof:?}");
    ensure!((proof.height_mm - solution.height_mm).abs() < 1e-6, "the height is not what was told");
    Ok(())
}
