//! `nestd nest`: the whole nester without a farm. Parts in, a proved build file out.

mod args;
mod output;
mod parts;
mod paths;
mod progress;
mod setup;

use std::{io::IsTerminal, sync::Arc};

use anyhow::Result;
use nester::{Cache, Instance, PreparedMeshes, SearchBudget, Solution};

use super::{Common, Exit, Usage, table::tell};
use crate::{build::BuildPart, farm::DiskCache};
pub use args::Args;
use progress::Progress;

/// What `--cache` may take up, bytes.
const CACHE_BYTES: u64 = 4 << 30;

/// Runs the command.
pub fn run(common: &Common, args: &Args) -> Result<Exit> {
    let setup = setup::setup(common, args)?;
    let rows = parts::rows(args)?;
    paths::check(args, &rows)?;
    let parts = parts::read(rows, &setup)?;
    let instance = setup.machine.instance(parts.iter().map(BuildPart::item).collect());
    let instance = instance.map_err(|error| Usage(error.to_string()))?;
    let prepared = PreparedMeshes::default().with_cache(cache(args)?);
    let budget =
        args.search.evaluations.map_or_else(|| SearchBudget::of_secs(args.search.budget), SearchBudget::of_evaluations);
    let mut progress = Progress::new(std::io::stderr().is_terminal(), budget.clone(), setup.machine.origin_mm().z);
    let solution = nester::nest_with(&instance, &setup.config, &[], &prepared, &budget, &mut progress);
    let course = progress.finish(setup.config.seed);
    name_unplaced(&instance, &solution);
    let report = output::write(args, &setup, parts, &instance, &solution, course)?;
    if std::io::stdout().is_terminal() {
        println!(
            "{:.2} mm high, {} of {} copies placed, density {:.3}, {:.1} s",
            report.height_mm,
            report.placed,
            instance.copies(),
            report.density,
            report.wall_secs
        );
    }
    Ok(if solution.unplaced.is_empty() { Exit::Success } else { Exit::Failure })
}

/// The cache that was asked for.
fn cache(args: &Args) -> Result<Option<Arc<dyn Cache + Send>>> {
    let Some(dir) = &args.cache else { return Ok(None) };
    let opened = DiskCache::open(dir, CACHE_BYTES);
    opened
        .map(|cache| Some(Arc::new(cache) as Arc<dyn Cache + Send>))
        .map_err(|error| Usage(format!("--cache {}: {error}", dir.display())).into())
}

/// Says which copies found no place, and why where it is known.
fn name_unplaced(instance: &Instance, solution: &Solution) {
    for (at, item) in instance.items().iter().enumerate() {
        let left_out = solution.unplaced.iter().filter(|(of, _)| *of == at).count();
        if left_out == 0 {
            continue;
        }
        match nester::fits(&item.mesh, &item.orientation, &instance.volume()) {
            Ok(_) => tell(&format!("{}: {left_out} of {} copies found no place", item.name, item.copies)),
            Err(misfit) => tell(&format!("{}: {}", item.name, misfit.reason(&instance.volume()))),
        }
    }
}
