//! `nestd nest`: nests parts into a proved build file without a farm.

mod args;
mod interrupt;
mod output;
mod parts;
mod paths;
mod progress;
mod setup;

use std::{collections::BTreeMap, io::IsTerminal, sync::Arc};

use anyhow::Result;
pub use args::NestArgs;
use delivery::build::BuildPart;
use farm::DiskPreparationCache;
use nester::{
    LeftOutFit, NestingInstance, NestingMethod, NestingReport, NestingSolution, PreparedMeshCache, PreparedMeshes,
    SearchBudget,
};
pub use parts::{RequestedFile, parse_part_argument};
use progress::{SearchProgress, SearchTarget, bound_and_gap};

use crate::cli::{CommandExit, CommonArgs, UsageError, terminal::table::print_to_stderr};

/// Largest size of the `--cache` folder, bytes.
const CACHE_BYTES: u64 = 4 << 30;

/// Runs the command.
pub fn run(common: &CommonArgs, args: &NestArgs) -> Result<CommandExit> {
    let setup = setup::resolve_setup(common, args)?;
    if args.search.until_bound && setup.config.method != NestingMethod::Nestd {
        return Err(UsageError("--until-bound needs --method nestd".to_owned()).into());
    }
    let rows = parts::requested_files(args)?;
    paths::check_paths(args, &rows)?;
    let parts = parts::read_parts(rows, &setup)?;
    let instance = setup.machine.create_instance(parts.iter().map(BuildPart::to_item).collect());
    let instance = instance.map_err(|error| UsageError(error.to_string()))?;
    let prepared = PreparedMeshes::default().with_cache(open_cache(args)?);
    let (search, budget) = (&args.search, begin_budget(args));
    let target = SearchTarget {
        floor_mm: setup.machine.origin_mm().z,
        bound_mm: nester::lower_bound_mm(&instance),
        copies: instance.copy_count(),
    };
    interrupt::end_on_signal(&budget)?;
    let mut progress = SearchProgress::new(std::io::stderr().is_terminal(), budget.clone(), target);
    let solution = match search.until_bound {
        true => nester::nest_until_lowest(&instance, &setup.config, &prepared, &budget, search.budget, &mut progress),
        false => nester::nest_with_cache(&instance, &setup.config, &[], &prepared, &budget, &mut progress),
    };
    let mut summary = progress.finish(setup.config.seed, &solution);
    summary.left_out = nester::examine_left_out(&instance, &setup.config, &solution, &prepared);
    report_unplaced(&instance, &solution, &summary.left_out);
    let report =
        output::write_outputs(args, &setup, parts, (&instance, target.machine_bound_mm()), &solution, summary)?;
    if report.placed > 0 {
        println!("{}", result_line(&report, target.copies, solution.is_lowest(target.bound_mm)));
    }
    Ok(if solution.unplaced.is_empty() { CommandExit::Success } else { CommandExit::Failure })
}

/// What ends the search, besides a layout at the lower bound.
fn begin_budget(args: &NestArgs) -> SearchBudget {
    let budget = match (args.search.evaluations, args.search.until_bound) {
        (Some(evaluations), _) => SearchBudget::of_evaluations(evaluations),
        (None, true) => SearchBudget::until_cancelled(),
        (None, false) => SearchBudget::of_secs(args.search.budget),
    };
    match args.search.patience {
        Some(secs) => budget.with_patience(secs),
        None => budget,
    }
}

/// `84.20 mm high, nothing gained for 40 s, bound 47.50, gap 43.6 %, 30 of 30 copies placed, density 0.310, 71.2 s`.
fn result_line(report: &NestingReport, copies: usize, is_lowest: bool) -> String {
    let NestingReport { packing, search, placed, .. } = report;
    let bound = match is_lowest {
        true => String::new(),
        false => format!("{}, ", bound_and_gap(packing.height_mm, packing.lower_bound_mm)),
    };
    format!(
        "{:.2} mm high, {}, {bound}{placed} of {copies} copies placed, density {:.3}, {:.1} s",
        packing.height_mm, search.ended, packing.density, search.wall_secs
    )
}

/// Opens the cache of the `--cache` option, if given.
fn open_cache(args: &NestArgs) -> Result<Option<Arc<dyn PreparedMeshCache + Send>>> {
    let Some(dir) = &args.cache else { return Ok(None) };
    let opened = DiskPreparationCache::open(dir, CACHE_BYTES);
    opened
        .map(|cache| Some(Arc::new(cache) as Arc<dyn PreparedMeshCache + Send>))
        .map_err(|error| UsageError(format!("--cache {}: {error}", dir.display())).into())
}

/// Reports the copies that found no place, and where they would fit.
fn report_unplaced(instance: &NestingInstance, solution: &NestingSolution, fits: &BTreeMap<usize, LeftOutFit>) {
    for (&item, fit) in fits {
        let count = solution.unplaced.iter().filter(|(of, _)| *of == item).count();
        let item = &instance.items()[item];
        print_to_stderr(&match fit.alone {
            true => format!("{}: {count} of {} copies found no place: {}", item.name, item.copies, fit.reason),
            false => format!("{}: {}", item.name, fit.reason),
        });
    }
}
