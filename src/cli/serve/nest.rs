//! `nestd nest`: nests parts into a proved build file without a farm.

mod args;
mod output;
mod parts;
mod paths;
mod progress;
mod setup;

use std::{collections::BTreeMap, io::IsTerminal, sync::Arc};

use anyhow::Result;
pub use args::NestArgs;
use nester::{LeftOutFit, NestingInstance, NestingSolution, PreparedMeshCache, PreparedMeshes, SearchBudget};
pub use parts::{RequestedFile, parse_part_argument};
use progress::SearchProgress;

use crate::{
    build::BuildPart,
    cli::{CommandExit, CommonArgs, UsageError, terminal::table::print_to_stderr},
    farm::DiskPreparationCache,
};

/// Largest size of the `--cache` folder, bytes.
const CACHE_BYTES: u64 = 4 << 30;

/// Runs the command.
pub fn run(common: &CommonArgs, args: &NestArgs) -> Result<CommandExit> {
    let setup = setup::resolve_setup(common, args)?;
    let rows = parts::requested_files(args)?;
    paths::check_paths(args, &rows)?;
    let parts = parts::read_parts(rows, &setup)?;
    let instance = setup.machine.create_instance(parts.iter().map(BuildPart::to_item).collect());
    let instance = instance.map_err(|error| UsageError(error.to_string()))?;
    let prepared = PreparedMeshes::default().with_cache(open_cache(args)?);
    let budget =
        args.search.evaluations.map_or_else(|| SearchBudget::of_secs(args.search.budget), SearchBudget::of_evaluations);
    let mut progress =
        SearchProgress::new(std::io::stderr().is_terminal(), budget.clone(), setup.machine.origin_mm().z);
    let solution = nester::nest_with_cache(&instance, &setup.config, &[], &prepared, &budget, &mut progress);
    let mut summary = progress.finish(setup.config.seed);
    summary.left_out = nester::examine_left_out(&instance, &setup.config, &solution, &prepared);
    report_unplaced(&instance, &solution, &summary.left_out);
    let report = output::write_outputs(args, &setup, parts, &instance, &solution, summary)?;
    if std::io::stdout().is_terminal() {
        println!(
            "{:.2} mm high, {} of {} copies placed, density {:.3}, {:.1} s",
            report.packing.height_mm,
            report.placed,
            instance.copy_count(),
            report.packing.density,
            report.search.wall_secs
        );
    }
    Ok(if solution.unplaced.is_empty() { CommandExit::Success } else { CommandExit::Failure })
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
