//! Which searches a bench is made of.

use anyhow::{Result, ensure};
use clap::ValueEnum;
use nester::{Method, Organs};

use super::{
    Args, cases,
    trial::{Budget, Trial},
};

/// A part of the bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Section {
    /// Our own method beside the published one at the same CPU seconds.
    Heights,
    /// Each organ taken out at fixed evaluations.
    Ablation,
    /// From 20 to 1,000 copies.
    Scale,
    /// How soon a first layout stands.
    First,
    /// Distance queries beside parry3d.
    Kernel,
    /// As heights, over the lists in NESTD_DATA.
    Data,
}

/// The workloads of the ablation.
pub const ABLATED: [&str; 3] = ["fans20", "engine30", "small60"];
/// Evaluations per copy in the scaling.
pub const SCALE_EVALUATIONS: u64 = 400;
/// Workloads whose first layouts are timed.
pub const FIRST: [&str; 2] = ["first-engine30", "first-700-200"];

/// Whether a section is to be measured.
pub fn asks_for(args: &Args, section: Section) -> bool {
    if args.only.is_empty() { section != Section::Data } else { args.only.contains(&section) }
}

/// All searches that the arguments ask for; the longest first, so that no core idles in the end.
pub fn plan(args: &Args) -> Result<Vec<Trial>> {
    let mut plan = Vec::new();
    let wanted =
        |case: &&str| args.cases.is_empty() || args.cases.iter().any(|c| c == case.trim_start_matches(cases::LISTED));
    if asks_for(args, Section::Heights) {
        plan.extend(cases::COMPARED.iter().filter(|c| wanted(c)).flat_map(|case| compared(args, case)));
    }
    if asks_for(args, Section::Data) {
        let lists = cases::lists()?;
        plan.extend(lists.iter().filter(|c| wanted(&c.as_str())).flat_map(|case| compared(args, case)));
    }
    if asks_for(args, Section::Ablation) {
        plan.extend(ABLATED.iter().filter(|c| wanted(c)).flat_map(|case| ablated(args, case)));
    }
    let ours = |case: &str, budget: Budget| trial(args, case, Method::Nestd, budget, 1);
    if asks_for(args, Section::Scale) {
        let scaled = |&copies: &u32| ours(&format!("scale-{copies}"), scale_budget(copies));
        plan.extend(cases::SCALE.iter().map(scaled).filter(|t| wanted(&t.case.as_str())));
    }
    if asks_for(args, Section::First) {
        plan.extend(FIRST.iter().filter(|c| wanted(c)).map(|case| ours(case, FIRST_BUDGET)));
    }
    ensure!(!plan.is_empty() || asks_for(args, Section::Kernel), "there is nothing to measure");
    plan.sort_by_key(|t: &Trial| match t.budget {
        Budget::CpuSecs(secs) => std::cmp::Reverse(secs),
        Budget::Evaluations(count) => std::cmp::Reverse(count / 30_000),
    });
    Ok(plan)
}

/// The budget of a scaling search.
pub fn scale_budget(copies: u32) -> Budget {
    Budget::Evaluations(SCALE_EVALUATIONS * u64::from(copies))
}

/// The budget of a search that is to show how soon a first layout stands.
pub const FIRST_BUDGET: Budget = Budget::CpuSecs(15);

fn trial(args: &Args, case: &str, method: Method, budget: Budget, seed: u64) -> Trial {
    let threads = if method == Method::Paper { 1 } else { args.threads };
    Trial { case: case.to_owned(), method, without: None, budget, seed, threads }
}

fn compared(args: &Args, case: &str) -> Vec<Trial> {
    let methods = if args.ours { vec![Method::Nestd] } else { vec![Method::Nestd, Method::Paper] };
    let budgets = args.secs.iter().map(|&secs| Budget::CpuSecs(secs));
    let both = budgets.flat_map(|budget| methods.iter().map(move |&method| (budget, method)));
    both.flat_map(|(budget, method)| (1..=args.seeds).map(move |seed| trial(args, case, method, budget, seed)))
        .collect()
}

fn ablated(args: &Args, case: &str) -> Vec<Trial> {
    let organs = Organs::each_taken_out().map(|(organ, _)| Some(organ.to_owned()));
    let of = |without: Option<String>, seed: u64| Trial {
        without,
        ..trial(args, case, Method::Nestd, Budget::Evaluations(args.evaluations), seed)
    };
    [None]
        .into_iter()
        .chain(organs)
        .flat_map(|organ| (1..=args.seeds).map(move |seed| of(organ.clone(), seed)))
        .collect()
}
