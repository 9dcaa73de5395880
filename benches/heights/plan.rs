//! The searches that make up a bench run.

use anyhow::{Result, ensure};
use clap::ValueEnum;
use nester::{NestingMethod, SearchComponents};
use sample_parts::COMPARED_WORKLOADS;

use super::{
    BenchArgs, cases,
    trial::{SearchTrial, TrialBudget},
};

/// A part of the bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BenchSection {
    /// Our own method beside the published one at the same CPU seconds.
    Heights,
    /// Each component disabled at fixed evaluations.
    Ablation,
    /// Each use of flower pollination disabled, at CPU seconds.
    Flowers,
    /// From 20 to 1,000 copies.
    Scale,
    /// Time to a first layout.
    First,
    /// Distance queries compared with parry3d.
    Kernel,
    /// As heights, over the lists in NESTD_DATA.
    Data,
}

/// The workloads of the ablation.
pub const ABLATED: [&str; 3] = ["engine30", "small200", "organic88"];
/// How the components begin that are a use of flower pollination.
const FLOWERS: &str = "flowers";
/// Evaluations per copy in the scaling.
pub const SCALE_EVALUATIONS: u64 = 400;
/// Workloads for the time to the first layout.
pub const FIRST: [&str; 2] = ["first-engine30", "first-700-200"];

/// Whether a section is to be measured.
pub fn asks_for(args: &BenchArgs, section: BenchSection) -> bool {
    if args.only.is_empty() { section != BenchSection::Data } else { args.only.contains(&section) }
}

/// The name of a list as its file has it; the page adds a prefix.
fn bare_name(case: &str) -> &str {
    case.trim_start_matches(cases::LISTED)
}

/// All searches that the arguments select; the longest first, so that no core is idle at the end.
pub fn plan(args: &BenchArgs) -> Result<Vec<SearchTrial>> {
    let mut plan = Vec::new();
    let wanted = |case: &&str| args.cases.is_empty() || args.cases.iter().any(|c| bare_name(c) == bare_name(case));
    if asks_for(args, BenchSection::Heights) {
        plan.extend(COMPARED_WORKLOADS.iter().map(|c| c.name).filter(wanted).flat_map(|case| compared(args, case)));
    }
    if asks_for(args, BenchSection::Data) {
        let lists = cases::lists()?;
        plan.extend(lists.iter().filter(|c| wanted(&c.as_str())).flat_map(|case| compared(args, case)));
    }
    if asks_for(args, BenchSection::Ablation) {
        let budget = TrialBudget::Evaluations(args.evaluations);
        plan.extend(ABLATED.iter().filter(|c| wanted(c)).flat_map(|case| ablated(args, case, budget, "")));
    }
    if asks_for(args, BenchSection::Flowers) {
        let budgets = || args.secs.iter().map(|&secs| TrialBudget::CpuSecs(secs));
        let of_case = |case: &'static &str| budgets().flat_map(move |budget| ablated(args, case, budget, FLOWERS));
        plan.extend(ABLATED.iter().filter(|c| wanted(c)).flat_map(of_case));
    }
    let ours = |case: &str, budget: TrialBudget| trial(args, case, NestingMethod::Nestd, budget, 1);
    if asks_for(args, BenchSection::Scale) {
        let scaled = |&copies: &u32| ours(&format!("scale-{copies}"), scale_budget(copies));
        plan.extend(cases::SCALE.iter().map(scaled).filter(|t| wanted(&t.case.as_str())));
    }
    if asks_for(args, BenchSection::First) {
        plan.extend(FIRST.iter().filter(|c| wanted(c)).map(|case| ours(case, FIRST_BUDGET)));
    }
    ensure!(
        !plan.is_empty() || asks_for(args, BenchSection::Kernel),
        "there is nothing to measure: no section of --only has a workload {}",
        args.cases.join(" or ")
    );
    let mut once: Vec<SearchTrial> = Vec::new();
    for trial in plan {
        if !once.contains(&trial) {
            once.push(trial);
        }
    }
    once.sort_by_key(|t: &SearchTrial| match t.budget {
        TrialBudget::CpuSecs(secs) => std::cmp::Reverse(secs),
        TrialBudget::Evaluations(count) => std::cmp::Reverse(count / 30_000),
    });
    Ok(once)
}

/// The budget of a scaling search.
pub fn scale_budget(copies: u32) -> TrialBudget {
    TrialBudget::Evaluations(SCALE_EVALUATIONS * u64::from(copies))
}

/// The budget of a search that measures the time to the first layout.
pub const FIRST_BUDGET: TrialBudget = TrialBudget::CpuSecs(15);

fn trial(args: &BenchArgs, case: &str, method: NestingMethod, budget: TrialBudget, seed: u64) -> SearchTrial {
    let threads = if method == NestingMethod::Paper { 1 } else { args.threads };
    SearchTrial { case: case.to_owned(), method, without: None, budget, seed, threads }
}

fn compared(args: &BenchArgs, case: &str) -> Vec<SearchTrial> {
    let methods = if args.ours { vec![NestingMethod::Nestd] } else { vec![NestingMethod::Nestd, NestingMethod::Paper] };
    let budgets = args.secs.iter().map(|&secs| TrialBudget::CpuSecs(secs));
    let both = budgets.flat_map(|budget| methods.iter().map(move |&method| (budget, method)));
    both.flat_map(|(budget, method)| (1..=args.seeds).map(move |seed| trial(args, case, method, budget, seed)))
        .collect()
}

/// Searches with all components, and without each whose name begins with `beginning`.
fn ablated(args: &BenchArgs, case: &str, budget: TrialBudget, beginning: &str) -> Vec<SearchTrial> {
    let components = SearchComponents::each_disabled().into_iter().filter(|(name, _)| name.starts_with(beginning));
    let components = components.map(|(name, _)| Some(name.to_owned()));
    let of = |without: Option<String>, seed: u64| SearchTrial {
        without,
        ..trial(args, case, NestingMethod::Nestd, budget, seed)
    };
    [None]
        .into_iter()
        .chain(components)
        .flat_map(|component| (1..=args.seeds).map(move |seed| of(component.clone(), seed)))
        .collect()
}
