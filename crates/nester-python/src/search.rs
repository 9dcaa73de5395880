//! The search on a thread of its own, with a callback into Python for every lower layout.

use std::sync::Arc;

use nester::{
    HeightCurve, NestingConfig, NestingInstance, NestingSolution, SearchBudget, find_fitting_rotation, lower_bound_mm,
    nest,
};
use pyo3::prelude::*;

use crate::{
    beside::{TaskReporter, run_reporting},
    errors::InputError,
    found_layout::FoundLayout,
    layout::PackedLayout,
    request::{ItemRequest, ItemSource, SearchRequest},
};

/// Height (mm) and wall seconds of a better layout.
type BetterHeight = (f64, f64);

/// Packs items. `on_better(height, seconds)` is called for every better layout; it ends the search by returning `False`.
///
/// # Errors
/// The input makes no sense, a part does not fit the volume, the callback has failed, or somebody has pressed Ctrl-C:
/// then the search is cancelled and ends by itself.
#[pyfunction]
pub(crate) fn search(
    py: Python<'_>,
    items: Vec<ItemRequest>,
    request: SearchRequest,
    on_better: Option<Py<PyAny>>,
) -> PyResult<PackedLayout> {
    let (instance, config) = (request.to_instance(&items)?, request.to_config()?);
    let sources = items.iter().map(ItemRequest::to_source).collect();
    let budget = request.begin_budget();
    let searched = budget.clone();
    let task = move |reporter: &TaskReporter<BetterHeight, _>| {
        check_fit(&instance)?;
        Ok(search_layout(instance, config, sources, &searched, |better| reporter.report(better)))
    };
    let found: PyResult<PyResult<FoundLayout>> = run_reporting(py, task, |better| {
        let Some(on_better) = &on_better else { return Ok(()) };
        if on_better.call1(py, better)?.extract::<bool>(py).is_ok_and(|goes_on| !goes_on) {
            budget.cancel();
        }
        Ok(())
    });
    if found.is_err() {
        budget.cancel();
    }
    Ok(PackedLayout { found: Arc::new(found??) })
}

/// Refuses a part that fits the volume in no allowed orientation, before anybody waits for the search.
fn check_fit(instance: &NestingInstance) -> PyResult<()> {
    let volume = instance.volume();
    for item in instance.items() {
        if let Err(misfit) = find_fitting_rotation(&item.mesh, &item.orientation, &volume) {
            return Err(InputError::new_err(format!(
                "{}: {}. Give a larger volume, allow more orientations, or check the unit of the part.",
                item.name,
                misfit.reason(&volume)
            )));
        }
    }
    Ok(())
}

fn search_layout(
    instance: NestingInstance,
    config: NestingConfig,
    sources: Vec<ItemSource>,
    budget: &SearchBudget,
    on_better: impl Fn(BetterHeight),
) -> FoundLayout {
    let mut curve = HeightCurve::default();
    let mut listener = |better: &NestingSolution, _evaluations: u64| {
        let secs = budget.elapsed_secs();
        if curve.add(better, secs) {
            budget.record_gain();
            on_better((better.height_mm, secs));
        }
    };
    let solution = nest(&instance, &config, &[], budget, &mut listener);
    let secs = budget.elapsed_secs();
    let lower_bound_mm = lower_bound_mm(&instance);
    let ended = budget.why_ended(solution.is_lowest(lower_bound_mm)).in_words();
    FoundLayout { instance, config, solution, sources, lower_bound_mm, heights: curve.points, secs, ended }
}
