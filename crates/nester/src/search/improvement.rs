//! Goes on lowering layouts for as long as somebody gives it time, in rounds. A round begins from a pool of different
//! layouts of the same copies, and leaves one for the next round: where a descent ends depends much on where it began.

use std::{collections::BTreeSet, sync::Arc};

use crate::{
    ItemPlacement, NestingConfig, NestingInstance, NestingMethod, NestingSolution, PreparedMeshes, ProgressListener,
    SearchBudget, SearchEnd, StopCondition, lower_bound_mm, nest_with_cache,
    prepare::prepared_instance::{PlacedItem, height_mm, solution_from_items},
    start::{nesting_run::NestingRun, retained::retained_items},
};

/// Share of a round's budget after which the height is not lowered any more.
const HEIGHT_SHARE: f64 = 0.98;
/// Meshes are as fine as if their preparation had taken this share of the budget, although it mostly takes none: each
/// evaluation of finer ones takes longer.
const PREPARED_SHARE: f64 = 0.036;
/// Maximum number of rounds of a search until the lowest layout.
const MAX_ROUNDS: u32 = 40;
/// Maximum number of layouts in a pool.
const MAX_POOL: usize = 4;

/// What a round of [`improve_layouts`] has found.
#[derive(Debug, Clone, PartialEq)]
pub struct ImprovedLayouts {
    /// The lowest layout. If no layout of the pool is valid, it was built anew, and may lack copies.
    pub best: NestingSolution,
    /// The pool for the next round: different layouts of the same copies, the lowest first. The first of them is `best`.
    pub pool: Vec<Vec<ItemPlacement>>,
}

/// One round of improvement: lowers the layouts of `pool` until the budget `stop` ends. A layout of the pool that is not
/// valid any more, or lacks a copy, is left out; if none is left, the round builds its own. Otherwise the result is never
/// higher than the lowest of them; `listener` receives that first, and then each lower one. The seed of `config` should
/// differ from round to round. Searches with nestd's own method, whatever `config` says.
///
/// ```
/// use std::sync::Arc;
/// use glam::DVec3;
/// use nester::{BuildVolume, NestingConfig, NestingInstance, NestingItem, PreparedMeshes, SearchBudget, improve_layouts, nest};
/// use solids::Mesh;
///
/// let clip = Arc::new(Mesh::tube(22.0, 17.0, 14.0)?);
/// let volume = BuildVolume { size_mm: DVec3::new(60.0, 60.0, 120.0) };
/// let instance = NestingInstance::new(volume, 1.5, vec![NestingItem::new("clip", clip, 6)])?;
/// let first = nest(&instance, &NestingConfig::default(), &[], &SearchBudget::of_evaluations(500), &mut ());
///
/// let (mut pool, prepared) = (vec![first.placements], PreparedMeshes::default());
/// for (seed, evaluations) in [(2, 500), (3, 1000)] {
///     let config = NestingConfig { seed, ..NestingConfig::default() };
///     let budget = SearchBudget::of_evaluations(evaluations);
///     let found = improve_layouts(&instance, &config, &pool, &prepared, &budget, &mut ());
///     assert!(found.best.unplaced.is_empty() && found.best.height_mm <= first.height_mm);
///     pool = found.pool;
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn improve_layouts(
    instance: &NestingInstance,
    config: &NestingConfig,
    pool: &[Vec<ItemPlacement>],
    prepared: &PreparedMeshes,
    stop: &dyn StopCondition,
    listener: &mut dyn ProgressListener,
) -> ImprovedLayouts {
    let own = NestingConfig { method: NestingMethod::Nestd, ..config.clone() };
    let mut run = NestingRun::new(instance, &own, prepared, stop, listener);
    if run.improve_pool(pool) {
        let solution = |items: &[PlacedItem]| solution_from_items(instance, items, run.evaluations);
        let pool = run.different_layouts().into_iter().map(|items| solution(items).placements).collect();
        return ImprovedLayouts { best: solution(&run.best_items), pool };
    }
    let best = nest_with_cache(instance, &own, &[], prepared, stop, listener);
    ImprovedLayouts { pool: vec![best.placements.clone()], best }
}

/// Nests in rounds, each twice as long as the one before, until no lower layout exists or the budget ends: it was
/// cancelled, or its patience is over. A time limit of the budget is not looked at; the first round takes `first_secs`
/// wall seconds. `listener` receives every better layout, and may receive it again when a round begins.
///
/// ```
/// use std::sync::Arc;
/// use glam::DVec3;
/// use nester::{BuildVolume, NestingConfig, NestingInstance, NestingItem, PreparedMeshes, SearchBudget, lower_bound_mm,
///     nest_until_lowest};
/// use solids::Mesh;
///
/// let brick = Arc::new(Mesh::cuboid(DVec3::new(30.0, 8.0, 20.0))?);
/// let volume = BuildVolume { size_mm: DVec3::new(60.0, 60.0, 120.0) };
/// let instance = NestingInstance::new(volume, 1.5, vec![NestingItem::new("brick", brick, 2)])?;
/// let (budget, prepared) = (SearchBudget::until_cancelled().with_patience(9.0), PreparedMeshes::default());
/// let found = nest_until_lowest(&instance, &NestingConfig::default(), &prepared, &budget, 1.0, &mut ());
/// assert!(found.is_lowest(lower_bound_mm(&instance)) && found.height_mm < 8.02);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn nest_until_lowest(
    instance: &NestingInstance,
    config: &NestingConfig,
    prepared: &PreparedMeshes,
    budget: &SearchBudget,
    first_secs: f64,
    listener: &mut dyn ProgressListener,
) -> NestingSolution {
    let bound_mm = lower_bound_mm(instance);
    let mut round = budget.begin_round(first_secs);
    let mut best = nest_with_cache(instance, config, &[], prepared, &round, listener);
    let (mut pool, mut evaluations) = (vec![best.placements.clone()], best.evaluations);
    for number in 1..=MAX_ROUNDS {
        if !matches!(round.why_ended(best.is_lowest(bound_mm)), SearchEnd::Used { .. }) {
            break;
        }
        let config = NestingConfig { seed: config.seed.wrapping_add(u64::from(number)), ..config.clone() };
        round = budget.begin_round(first_secs * 2f64.powi(number.min(20) as i32));
        if best.unplaced.is_empty() {
            ImprovedLayouts { best, pool } = improve_layouts(instance, &config, &pool, prepared, &round, listener);
        } else {
            best = nest_with_cache(instance, &config, &best.placements, prepared, &round, listener);
            pool = vec![best.placements.clone()];
        }
        evaluations += best.evaluations;
    }
    NestingSolution { evaluations, ..best }
}

impl NestingRun<'_> {
    /// Lowers the layouts of a pool. Returns whether one of them is valid.
    fn improve_pool(&mut self, pool: &[Vec<ItemPlacement>]) -> bool {
        let Some(task) = self.prepare_instance(Arc::new(self.outline_instance())) else { return false };
        for layout in pool {
            let items = retained_items(&task, self.instance, layout);
            if items.len() == task.copies.len() {
                self.offer_first_layout(items);
            }
        }
        if self.best_items.is_empty() {
            return false;
        }
        let task = self.with_finer_proxies(task, PREPARED_SHARE);
        self.compress_layouts(&task, HEIGHT_SHARE);
        self.finish_layout(&task);
        true
    }

    /// The best layout, and the lowest others: where descents ended, and where they began or might have begun.
    fn different_layouts(&self) -> Vec<&Vec<PlacedItem>> {
        let mut others: Vec<&Vec<PlacedItem>> = self.other_ends.iter().chain(&self.first_layouts).collect();
        others.sort_by(|one, other| height_mm(one).total_cmp(&height_mm(other)));
        let mut heights = BTreeSet::from([height_mm(&self.best_items).to_bits()]);
        others.retain(|items| heights.insert(height_mm(items).to_bits()));
        std::iter::once(&self.best_items).chain(others).take(MAX_POOL).collect()
    }
}
