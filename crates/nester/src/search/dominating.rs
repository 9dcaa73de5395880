//! Few large parts may decide the height of a build. A search that moves all parts hardly ever finds another arrangement
//! of them: whatever stands between them would have to move at the same time. So the large parts are searched alone, and
//! first layouts are built around what is found.
//!
//! Tried in vain: 20 % of the budget instead of 12 % for the large parts (wheels23 level, five seeds). Where the others fill
//! nearly all the room that a low pile would leave (a build 45 % solid), layouts around leaning parts lose against the pile.

use std::collections::BTreeSet;

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

use super::{
    compression::DescentPace,
    tournament::{DescentStart, run_tournament},
};
use crate::{
    prepare::prepared_instance::{PlacedItem, PreparedInstance, height_mm},
    start::{insert::missing_copies, layout_builder::LayoutBuilder, nesting_run::NestingRun, recipe::PlacementRecipe},
};

/// Item and copy.
type CopyIndex = (usize, u32);

/// Parts dominate when a first layout of them alone has at least this share of the whole height,
const LEAST_HEIGHT_SHARE: f64 = 0.9;
/// and when they are at most this share of the copies, and at most this number: every search pays for looking for them.
const MAX_COPIES: (f64, usize) = (0.4, 12);
/// Items at most that may turn out not to dominate.
const MAX_ITEMS_LEFT_OUT: usize = 12;
/// Share of the budget for finding the dominating parts.
const FINDING_SHARE: f64 = 0.04;
/// Share of the budget for them alone.
const ALONE_SHARE: f64 = 0.12;
/// Share of the budget for building the others around them.
const AROUND_SHARE: f64 = 0.04;
/// Others are built around the dominating parts when these stand lower by at least this ratio.
const WORTHWHILE_RATIO: f64 = 0.98;

impl NestingRun<'_> {
    /// Searches the dominating parts alone, if there are some, and offers layouts that are built around them.
    pub(super) fn begin_from_dominating(&mut self, task: &PreparedInstance) {
        let is_whole = self.best_items.len() == task.copies.len() && task.pinned.is_empty();
        if !is_whole || !self.config.components.separation || self.is_lowest(task) {
            return;
        }
        let mut builder = LayoutBuilder::new(task);
        let Some(pieces) = self.find_dominating(task, &mut builder) else { return };
        let floor_mm = self.floor_mm(task);
        let layouts = [pieces];
        let start = DescentStart {
            prepared: task,
            layouts: &layouts,
            floor_mm,
            seed: self.config.seed,
            pace: DescentPace::default(),
            least_runs: 1,
        };
        let (stop, before) = (self.stop, self.evaluations);
        let begun = stop.spent_share_at(before);
        let spent = |made: u64| (stop.spent_share_at(before + made) - begun) / ALONE_SHARE;
        let alone = run_tournament(&start, &spent, &mut |_, _| ());
        self.evaluations += alone.made;
        if height_mm(&alone.items) <= WORTHWHILE_RATIO * height_mm(&layouts[0]) {
            self.build_around(task, &mut builder, &alone.items);
        }
    }

    /// A first layout of the fewest large items, in all their copies, that is nearly as high as the best layout.
    fn find_dominating<'t>(
        &mut self,
        task: &'t PreparedInstance,
        builder: &mut LayoutBuilder<'t>,
    ) -> Option<Vec<PlacedItem>> {
        let recipe = &PlacementRecipe::FIRST[0];
        let mut rng = ChaCha8Rng::seed_from_u64(self.config.seed);
        let order = recipe.sort_copies(&task.outlined, &task.copies, &mut rng);
        let most = ((MAX_COPIES.0 * order.len() as f64) as usize).min(MAX_COPIES.1);
        let wanted_mm = LEAST_HEIGHT_SHARE * height_mm(&self.best_items);
        let until = self.stop.spent_share_at(self.evaluations) + FINDING_SHARE;
        let mut build = |run: &mut Self, order: &[CopyIndex]| {
            let build = |builder: &mut LayoutBuilder<'t>, enough: &mut dyn FnMut(u64) -> bool| {
                builder.build_separable(recipe, order, &[], enough)
            };
            run.run_builder(builder, until, build).filter(|built| built.len() == order.len())
        };
        // Of parts placed one after the other, the first ones stand as they would without the others.
        let first = build(self, &order[..most])?;
        let last = first.iter().position(|piece| piece.bounds.max.z >= wanted_mm)?;
        let mut items: BTreeSet<usize> = first[..=last].iter().map(|piece| piece.item).collect();
        let copies_of = |items: &BTreeSet<usize>| -> Vec<CopyIndex> {
            order.iter().copied().filter(|copy| items.contains(&copy.0)).collect()
        };
        for item in items.clone().into_iter().take(MAX_ITEMS_LEFT_OUT) {
            let fewer: BTreeSet<usize> = items.iter().copied().filter(|&other| other != item).collect();
            if build(self, &copies_of(&fewer)).is_some_and(|built| height_mm(&built) >= wanted_mm) {
                items = fewer;
            }
        }
        let copies = copies_of(&items);
        if copies.len() < 2 || copies.len() > most { None } else { build(self, &copies) }
    }

    /// Builds layouts around pieces, of which the lowest is a start of its own.
    fn build_around<'t>(&mut self, task: &'t PreparedInstance, builder: &mut LayoutBuilder<'t>, pieces: &[PlacedItem]) {
        let mut rng = ChaCha8Rng::seed_from_u64(self.config.seed);
        let others = missing_copies(task, pieces);
        let until = self.stop.spent_share_at(self.evaluations) + AROUND_SHARE;
        let mut lowest: Option<Vec<PlacedItem>> = None;
        for recipe in PlacementRecipe::FIRST {
            let all = recipe.sort_copies(&task.outlined, &task.copies, &mut rng);
            let order: Vec<CopyIndex> = all.iter().copied().filter(|copy| others.contains(copy)).collect();
            let built = self.run_builder(builder, until, |builder, enough| {
                let built = builder.build_once(&recipe, &order, pieces, f64::INFINITY, enough)?;
                builder.make_separable(&recipe, &all, built, enough)
            });
            let Some(built) = built.filter(|built| built.len() == task.copies.len()) else { continue };
            if lowest.as_ref().is_none_or(|lowest| height_mm(&built) < height_mm(lowest)) {
                lowest = Some(built);
            }
        }
        let Some(lowest) = lowest else { return };
        self.around_dominating = Some(lowest.clone());
        self.offer_layout(lowest);
    }
}
