//! The tables of the page.

use std::collections::BTreeMap;

use nester::{NestingMethod, SearchComponents};
use sample_parts::COMPARED_WORKLOADS;

use super::{
    cases,
    plan::{self, ABLATED, FIRST, FIRST_BUDGET},
    record_book::{KernelRecord, MeasurementOrigin, SearchRecord},
    repository,
    statistics::{HALF_INTERVAL, mean_and_variance},
    trial::{SearchFinding, TrialBudget},
};

/// What the column of other packers needs to be read.
const ABOUT_OTHERS: &str = "\
Others: sparrow-3d is an open source packer that rotates parts about one axis only and packs enlarged parts; \"prototype\" is
an early version of this search. Both with one thread and one seed.";

/// Values of the same search with different seeds.
struct SeedSample(Vec<f64>);

impl SeedSample {
    fn of(findings: &[&SearchFinding], value: impl Fn(&SearchFinding) -> f64) -> Self {
        Self(findings.iter().map(|f| value(f)).collect())
    }

    fn mean(&self) -> f64 {
        mean_and_variance(&self.0).0
    }

    /// The relative change of the mean against another sample, and its variance; NaN where a sample has one value.
    fn change_against(&self, base: &Self) -> (f64, f64) {
        let ((mean, variance), (base_mean, base_variance)) = (mean_and_variance(&self.0), mean_and_variance(&base.0));
        (mean / base_mean - 1.0, variance / mean.powi(2) + base_variance / base_mean.powi(2))
    }

    /// The mean as text.
    fn mean_text(&self) -> String {
        format!("{:.1}", self.mean())
    }
}

/// Heights of complete layouts; says if copies found no place.
fn height(findings: &[&SearchFinding]) -> String {
    let whole: Vec<&SearchFinding> = findings.iter().copied().filter(|f| f.unplaced == 0).collect();
    match (whole.len(), findings.len()) {
        (_, 0) => "-".to_owned(),
        (0, _) => "no whole layout".to_owned(),
        (some, all) if some < all => {
            format!("{}, {} of {all} whole", SeedSample::of(&whole, |f| f.height_mm).mean_text(), some)
        }
        _ => SeedSample::of(&whole, |f| f.height_mm).mean_text(),
    }
}

fn thousands(number: f64) -> String {
    let digits = format!("{number:.0}");
    let groups: Vec<&str> = digits.as_bytes().rchunks(3).rev().map(|g| std::str::from_utf8(g).unwrap_or("")).collect();
    groups.join(",")
}

fn machine(case: &str) -> String {
    cases::instance(case).map_or_else(|_| "-".to_owned(), |instance| cases::machine(&instance))
}

/// The heights that other packers reached on a list, from `benches/references.toml`.
fn others(case: &str) -> String {
    let Some(list) = case.strip_prefix(cases::LISTED) else { return String::new() };
    let text = std::fs::read_to_string(repository("benches/references.toml")).unwrap_or_default();
    let known: BTreeMap<String, BTreeMap<String, f64>> = toml::from_str(&text).unwrap_or_default();
    let told = known.get(list).into_iter().flatten().map(|(who, mm)| format!("{mm:.1} ({who})"));
    format!(" {} |", told.collect::<Vec<_>>().join("; "))
}

/// Like [`heights`], with the heights that others reached.
pub fn listed(records: &[&SearchRecord]) -> (String, Vec<MeasurementOrigin>) {
    let (text, origins) = heights(records);
    let head = text.replacen("| lower bound |\n|", "| lower bound | others |\n|---|", 1);
    (format!("{ABOUT_OTHERS}\n\n{head}"), origins)
}

/// CPU seconds of the searches that the page compares: short ones, and long ones.
const COMPARED_SECS: [u64; 2] = [10, 60];

/// Our own method compared with the published one, a row for each workload.
pub fn heights(records: &[&SearchRecord]) -> (String, Vec<MeasurementOrigin>) {
    // Our short and long searches, and the long ones of the published method.
    let mut rows: BTreeMap<(usize, &str), [Vec<&SearchFinding>; 3]> = BTreeMap::new();
    let mut origins = Vec::new();
    for record in records.iter().filter(|r| r.finding.trial.without.is_none() && r.finding.trial.threads == 1) {
        let (f, trial) = (&record.finding, &record.finding.trial);
        let known = COMPARED_WORKLOADS.iter().position(|c| c.name == trial.case).unwrap_or(usize::MAX);
        let [short, long] = COMPARED_SECS.map(|secs| trial.budget == TrialBudget::CpuSecs(secs));
        let cell = match (short, long, trial.method == NestingMethod::Paper) {
            (true, _, false) => 0,
            (_, true, false) => 1,
            (_, true, true) => 2,
            _ => continue,
        };
        rows.entry((known, &trial.case)).or_default()[cell].push(f);
        origins.push(record.origin.clone());
    }
    let mut text =
        "| workload | copies (meshes) | published method, 60 s | nestd, 10 s | nestd, 60 s | ratio | lower bound |\n\
                    |---|---|---|---|---|---|---|\n"
            .to_owned();
    for ((_, case), [short, long, theirs]) in &rows {
        let Some(any) = long.first().or(short.first()) else { continue };
        text.push_str(&format!(
            "| {case} | {} ({}) | {} | {} | **{}** | {} | {:.1} |{}\n",
            any.copies,
            any.meshes,
            height(theirs),
            height(short),
            height(long),
            ratio(long, theirs),
            any.lower_bound_mm,
            others(case),
        ));
    }
    (text, origins)
}

/// Our mean height divided by theirs, when all layouts are complete.
fn ratio(ours: &[&SearchFinding], theirs: &[&SearchFinding]) -> String {
    let whole = |findings: &[&SearchFinding]| !findings.is_empty() && findings.iter().all(|f| f.unplaced == 0);
    if !whole(ours) || !whole(theirs) {
        return "-".to_owned();
    }
    let mean = |findings: &[&SearchFinding]| SeedSample::of(findings, |f| f.height_mm).mean();
    format!("{:.3}", mean(ours) / mean(theirs))
}

/// Each component disabled, at the most evaluations that were measured.
pub fn ablation(records: &[&SearchRecord]) -> (String, Vec<MeasurementOrigin>) {
    changes(records, |budget| match budget {
        TrialBudget::Evaluations(count) => Some(format!("{} evaluations", thousands(count as f64))),
        TrialBudget::CpuSecs(_) => None,
    })
}

/// Each use of flower pollination disabled, at the most CPU seconds that were measured.
pub fn flowers(records: &[&SearchRecord]) -> (String, Vec<MeasurementOrigin>) {
    changes(records, |budget| match budget {
        TrialBudget::CpuSecs(secs) => Some(format!("{secs} CPU seconds")),
        TrialBudget::Evaluations(_) => None,
    })
}

/// The change that each disabled component makes, at the greatest budget that `describe` has words for.
fn changes(
    records: &[&SearchRecord],
    describe: impl Fn(TrialBudget) -> Option<String>,
) -> (String, Vec<MeasurementOrigin>) {
    let ablated = records.iter().filter(|r| r.finding.trial.without.is_some()).map(|r| r.finding.trial.budget);
    let Some((budget, words)) = ablated.filter_map(|budget| Some((budget, describe(budget)?))).max() else {
        return Default::default();
    };
    let mut origins = Vec::new();
    let mut of = |case: &str, without: Option<&str>| -> Vec<&SearchFinding> {
        let of_trial = |r: &&&SearchRecord| {
            let trial = &r.finding.trial;
            trial.case == case
                && trial.without.as_deref() == without
                && trial.budget == budget
                && trial.method == NestingMethod::Nestd
        };
        let found: Vec<&SearchRecord> = records.iter().filter(of_trial).copied().collect();
        origins.extend(found.iter().map(|r| r.origin.clone()));
        found.iter().map(|r| &r.finding).collect()
    };
    let wholes = ABLATED.map(|case| of(case, None));
    let seeds = wholes.iter().map(Vec::len).max().unwrap_or(0);
    let mut text = format!(
        "Change of the mean height at {words} with up to {seeds} seeds against the whole search, with its 95 % interval; mean of {}.\n\n\
         | without | change |\n|---|---|\n",
        ABLATED.join(", ")
    );
    for (component, _) in SearchComponents::each_disabled() {
        let found = ABLATED.map(|case| of(case, Some(component)));
        if found.iter().any(|found| !found.is_empty()) {
            text.push_str(&row_of_changes(component, &found, &wholes));
        }
    }
    (text, origins)
}

/// The searches without a component beside the whole ones.
fn row_of_changes(component: &str, found: &[Vec<&SearchFinding>], wholes: &[Vec<&SearchFinding>]) -> String {
    let heights = |findings: &[&SearchFinding]| SeedSample::of(findings, |f| f.height_mm);
    let pairs = found.iter().zip(wholes).filter(|(found, whole)| !found.is_empty() && !whole.is_empty());
    let told = pairs.filter(|(found, whole)| !are_the_same(found, whole));
    let changes: Vec<(f64, f64)> = told.map(|(found, whole)| heights(found).change_against(&heights(whole))).collect();
    let told = if changes.is_empty() { "took no part".to_owned() } else { told_change(&changes) };
    format!("| {component} | {told} |\n")
}

/// Whether the searches of each seed did the same.
fn are_the_same(found: &[&SearchFinding], whole: &[&SearchFinding]) -> bool {
    let did = |f: &SearchFinding| (f.height_mm.to_bits(), f.evaluations);
    let same_seed = |f: &SearchFinding| whole.iter().find(|w| w.trial.seed == f.trial.seed).map(|w| did(w));
    found.iter().all(|f| same_seed(f) == Some(did(f)))
}

/// The mean of relative changes and its 95 % interval, in percent; each change with the variance of its mean, which is NaN
/// when it is not known.
fn told_change(changes: &[(f64, f64)]) -> String {
    let count = changes.len() as f64;
    let mean = changes.iter().map(|change| change.0).sum::<f64>() / count;
    let half = HALF_INTERVAL * changes.iter().map(|change| change.1).sum::<f64>().sqrt() / count;
    match (changes.is_empty(), half.is_nan()) {
        (true, _) => String::new(),
        (false, true) => format!("{:+.1} %", 100.0 * mean),
        (false, false) => format!("{:+.1} ± {:.1} %", 100.0 * mean, 100.0 * half),
    }
}

/// Growing piles on one machine.
pub fn scale(records: &[&SearchRecord]) -> (String, Vec<MeasurementOrigin>) {
    let mut text = format!(
        "Small parts of the project's own on a base of {}, {} evaluations per copy.\n\n| copies (meshes) | triangles \
         | first layout, s | height | CPU s | memory, MiB |\n|---|---|---|---|---|---|\n",
        machine("scale-20"),
        plan::SCALE_EVALUATIONS
    );
    let mut origins = Vec::new();
    for copies in cases::SCALE {
        let of = |r: &&&SearchRecord| {
            let trial = &r.finding.trial;
            trial.case == format!("scale-{copies}") && trial.budget == plan::scale_budget(copies)
        };
        let Some(record) = records.iter().find(of) else { continue };
        let f = &record.finding;
        let first_secs = f.curve.first().map_or(f64::NAN, |step| step.0);
        text.push_str(&format!(
            "| {} ({}) | {} | {first_secs:.2} | {} | {:.1} | {:.0} |\n",
            f.copies,
            f.meshes,
            thousands(f.triangles as f64),
            height(&[f]),
            f.cpu_secs,
            f.peak_mib
        ));
        origins.push(record.origin.clone());
    }
    (text, origins)
}

/// The time to the first layout.
pub fn first_layouts(records: &[&SearchRecord]) -> (String, Vec<MeasurementOrigin>) {
    let mut text = "CPU seconds of one core from the meshes in memory, nothing prepared before, to the first layout of all copies.\n\n\
                    | workload | copies (meshes) | first layout, s | its height | height at the end |\n|---|---|---|---|---|\n"
        .to_owned();
    let mut origins = Vec::new();
    for record in records.iter().filter(|r| r.finding.trial.budget == FIRST_BUDGET) {
        let f = &record.finding;
        if FIRST.contains(&f.trial.case.as_str()) {
            let (secs, mm) = f.curve.first().map_or((f64::NAN, f64::NAN), |step| (step.0, step.2));
            text.push_str(&format!(
                "| {} | {} ({}) | {secs:.2} | {mm:.1} | {} |\n",
                f.trial.case,
                f.copies,
                f.meshes,
                height(&[f])
            ));
            origins.push(record.origin.clone());
        }
    }
    (text, origins)
}

/// Both kernels.
pub fn kernel(records: &[KernelRecord]) -> String {
    let mut text = "Queries per CPU second on the same pairs of parts in random turns, up to the clearance: *just clear* pairs stand at \
                    most 0.05 mm further\napart than that, *too close* ones half of it on average.\n\n\
                    | pairs | triangles | nestd | parry3d | ratio | greatest difference, mm |\n|---|---|---|---|---|---|\n"
        .to_owned();
    for r in records {
        text.push_str(&format!(
            "| {} | {} | {} | {} | {:.1} | {:.0e} |\n",
            r.pairs,
            thousands(r.triangles as f64),
            thousands(r.distances_per_sec),
            thousands(r.parry_capped_per_sec),
            r.distances_per_sec / r.parry_capped_per_sec,
            r.difference_mm
        ));
    }
    text
}
