//! The first layouts: retained placements, stacked boxes, and voxel placement with recipes that flower pollination
//! proposes. The descents begin from the lowest ones.
//!
//! Tried in vain for equal copies, at 200,000 evaluations, without and with:
//! - Unit cells: one or two poses and three lattice vectors that flower pollination proposes, made dense by exact slides and
//!   tiled from the floor up, and the builder around them. With 8 % of the budget for cells, 60 lampshades that stand in each
//!   other ended at 145.0 and 127.8 mm (four seeds, -11.9 ± 2.6 %), 60 connecting rods at 123.6 and 118.4 (-4 ± 13 %), fans20
//!   level; but one lattice on another lost (twins120 +3.1 ± 2.2 %), and so did 60 ribbed brackets (two seeds, 124.1 and 136.0).
//!   With other first genomes and a limit for the builder, the lampshades gained little (three seeds, -6 ± 15 %): 180 cells are
//!   too few to find a good one for sure. Beside a lattice, a base that is four parts wide stays empty.
//! - Compounds: 2, 4 or 8 copies as one rigid part, chosen by the box around them. Rods began at 138 and 135 mm, lampshades at
//!   169 and 158, and these ended level; six other workloads began no lower (one seed).
//! - The builder with one to four random rotations instead of 40: 200 layouts cost 37,000 to 212,000 evaluations. Of eight
//!   workloads (one seed, 20,000 evaluations for the rest), rods began at 148 and 136 mm, lampshades at 182 and 146, tees at 185
//!   and 168, and five no lower.

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

use super::{
    box_stacker::BoxStacker,
    insert::{are_few, missing_copies},
    layout_builder::LayoutBuilder,
    nesting_run::{MAX_HEIGHT_RATIO, NestingRun, rank},
    recipe::PlacementRecipe,
    retained::retained_items,
    truncate_queue::exceeds_capacity,
};
use crate::{
    ItemPlacement,
    pollination::{FlowerPollination, PollinationSettings},
    prepare::prepared_instance::{PlacedItem, PreparedInstance, height_mm},
};

/// Share of the budget for the first layouts, after the very first one.
const START_SHARE: f64 = 0.1;
/// Shares of what is then left of [`START_SHARE`] after which no more recipes are tried, and no more layouts built in finer
/// voxels. The rest is for taking parts out of the lowest layouts that are locked, and placing them elsewhere.
const RECIPES_UNTIL: f64 = 0.35;
const FINER_UNTIL: f64 = 0.85;
/// Greatest number of recipes that flower pollination proposes.
const MAX_PROPOSALS: usize = 24;
/// How much finer voxels are, at least and at most.
const FINER_VOXELS: (f64, f64) = (1.15, 2.0);
/// The power of the fineness with which the cost of a first layout grows: 2.3 measured, and a margin.
const FINENESS_COST: f64 = 2.5;
/// Number of orders that are built in finer voxels, and of these in still finer ones.
const FINER_COUNTS: [usize; 2] = [4, 1];
/// Greatest ratio of the edges of still finer voxels to those before.
const LEAST_REFINEMENT: f64 = 0.9;
/// Number of first layouts that are kept as starting points.
const MAX_FIRST_LAYOUTS: usize = 8;

/// A layout in which parts may still be locked, and how it was made.
struct Draft {
    recipe: PlacementRecipe,
    order: Vec<(usize, u32)>,
    pieces: Vec<PlacedItem>,
    /// Whether it was made separable and offered.
    is_offered: bool,
}

/// The first layouts while they are built.
struct Drafting<'a> {
    task: &'a PreparedInstance,
    standing: &'a [PlacedItem],
    missing: &'a [(usize, u32)],
    rng: ChaCha8Rng,
    /// Share of the budget that the last draft took, without making it separable.
    cost: f64,
    /// The drafts of all copies, the lowest first.
    drafts: Vec<Draft>,
}

impl Draft {
    fn height_mm(&self) -> f64 {
        height_mm(&self.pieces)
    }
}

impl Drafting<'_> {
    fn keep(&mut self, draft: Draft) {
        let height_mm = draft.height_mm();
        let at = self.drafts.partition_point(|known| known.height_mm() <= height_mm);
        self.drafts.insert(at, draft);
    }
}

/// How much finer voxels may be for a first layout within the share `left` of the budget, when one in the usual voxels takes
/// the share `cost`; `None` when that is too little to be worth a layout.
pub(crate) fn finer_voxels(left: f64, cost: f64) -> Option<f64> {
    let factor = (left.max(0.0) / cost.max(1e-9)).powf(1.0 / FINENESS_COST);
    (factor >= FINER_VOXELS.0).then_some(factor.min(FINER_VOXELS.1))
}

impl NestingRun<'_> {
    /// Builds the first layouts: retained placements, stacked boxes, and voxel placement with several recipes.
    pub(crate) fn build_first_layouts(&mut self, task: &PreparedInstance, start: &[ItemPlacement]) {
        let standing = retained_items(task, self.instance, start);
        let missing = missing_copies(task, &standing);
        if !standing.is_empty() {
            self.offer_layout(BoxStacker::new(&task.outlined).stack_copies(&standing, &missing));
        }
        if missing.is_empty() {
            return;
        }
        if are_few(&missing, &standing) {
            self.insert_missing(task, &standing, &missing);
            if self.best_items.len() == standing.len() + missing.len() {
                return;
            }
        }
        let mut builder = LayoutBuilder::new(task);
        if exceeds_capacity(self.instance, &missing) {
            return self.place_by_precedence(task, &mut builder, &standing, &missing);
        }
        let mut drafting = Drafting {
            task,
            standing: &standing,
            missing: &missing,
            rng: ChaCha8Rng::seed_from_u64(self.config.seed),
            cost: 0.0,
            drafts: Vec::new(),
        };
        self.draft_layouts(&mut drafting, &mut builder);
        if self.best_items.len() < task.copies.len() {
            self.place_by_precedence(task, &mut builder, &standing, &missing);
        }
    }

    /// Builds layouts with several recipes, and the best of them in finer voxels; then offers the lowest ones.
    fn draft_layouts(&mut self, drafting: &mut Drafting<'_>, builder: &mut LayoutBuilder<'_>) {
        self.try_recipe(drafting, builder, PlacementRecipe::FIRST[0], 1.0);
        let cost = drafting.cost;
        let from = self.spent_share();
        if from >= START_SHARE || self.is_lowest(drafting.task) {
            return;
        }
        let until = |share: f64| from + share * (START_SHARE - from);
        self.try_recipes(drafting, builder, until(RECIPES_UNTIL));
        self.try_finer(drafting, (cost, builder.pitch), until(FINER_UNTIL));
        for mut draft in std::mem::take(&mut drafting.drafts).into_iter().take(MAX_FIRST_LAYOUTS) {
            if self.spent_share() < START_SHARE && !draft.is_offered {
                self.offer_draft(builder, &mut draft, START_SHARE);
            }
        }
    }

    fn spent_share(&self) -> f64 {
        self.stop.spent_share_at(self.evaluations)
    }

    /// Builds a layout with a recipe: see [`NestingRun::try_order`].
    fn try_recipe(
        &mut self,
        drafting: &mut Drafting<'_>,
        builder: &mut LayoutBuilder<'_>,
        recipe: PlacementRecipe,
        until: f64,
    ) -> f64 {
        let order = recipe.sort_copies(&drafting.task.outlined, drafting.missing, &mut drafting.rng);
        self.try_order(drafting, builder, (recipe, order), until)
    }

    /// Builds a layout, and keeps it if it contains all copies; unless the share `until` of the budget is used up first, or
    /// the layout gets much higher than the best one. Offers it if it may be better than the best one: the others wait,
    /// because to make a layout of hundreds of parts separable costs more than to build it. Returns its height in mm
    /// before it was made separable, infinite if there is no layout of all copies.
    fn try_order(
        &mut self,
        drafting: &mut Drafting<'_>,
        builder: &mut LayoutBuilder<'_>,
        (recipe, order): (PlacementRecipe, Vec<(usize, u32)>),
        until: f64,
    ) -> f64 {
        let (begun, copies) = (self.spent_share(), drafting.task.copies.len());
        let whole = self.best_items.len() == copies;
        let worst_mm = if whole { MAX_HEIGHT_RATIO * height_mm(&self.best_items) } else { f64::INFINITY };
        let built = self.run_builder(builder, until, |builder, enough| {
            builder.build_once(&recipe, &order, drafting.standing, worst_mm, enough)
        });
        drafting.cost = self.spent_share() - begun;
        let Some(pieces) = built else { return f64::INFINITY };
        let mut draft = Draft { recipe, order, pieces, is_offered: false };
        let raw_mm = if draft.pieces.len() == copies { draft.height_mm() } else { f64::INFINITY };
        if rank(&draft.pieces) < rank(&self.best_items) || !drafting.task.must_be_separable {
            self.offer_draft(builder, &mut draft, until);
        }
        if draft.pieces.len() == copies {
            drafting.keep(draft);
        }
        raw_mm
    }

    /// Makes a draft separable and offers it.
    fn offer_draft(&mut self, builder: &mut LayoutBuilder<'_>, draft: &mut Draft, until: f64) {
        let Draft { recipe, order, pieces, .. } = &*draft;
        let made = self.run_builder(builder, until, |builder, enough| {
            builder.make_separable(recipe, order, pieces.clone(), enough)
        });
        if let Some(pieces) = made {
            self.offer_first_layout(pieces.clone());
            (draft.pieces, draft.is_offered) = (pieces, true);
        }
    }

    /// Offers a first layout, and keeps it as a starting point unless a first layout of the same height exists.
    pub(crate) fn offer_first_layout(&mut self, pieces: Vec<PlacedItem>) {
        let height = height_mm(&pieces);
        if self.first_layouts.iter().all(|known| height_mm(known) != height) {
            let at = self.first_layouts.partition_point(|known| height_mm(known) <= height);
            self.first_layouts.insert(at, pieces.clone());
            self.first_layouts.truncate(MAX_FIRST_LAYOUTS);
        }
        self.offer_layout(pieces);
    }

    /// Tries more recipes, first some that are the same for all and then what flower pollination proposes: order, weight of the
    /// part's height, direction of the pull, and random variation.
    fn try_recipes(&mut self, drafting: &mut Drafting<'_>, builder: &mut LayoutBuilder<'_>, until: f64) {
        let setup = PollinationSettings {
            population: 8,
            even: !self.config.components.flowers_in_start,
            ..PollinationSettings::default()
        };
        let mut flowers: FlowerPollination<f64> =
            FlowerPollination::new(setup, PlacementRecipe::gene_ranges(), self.config.seed);
        for at in 1..PlacementRecipe::FIRST.len() + MAX_PROPOSALS {
            // The first one took longer than the next one will.
            if self.spent_share() + if at == 1 { 0.0 } else { drafting.cost } > until {
                return;
            }
            let known = PlacementRecipe::FIRST.get(at).copied();
            let recipe = known.unwrap_or_else(|| PlacementRecipe::from_genes(flowers.ask()));
            let raw_mm = self.try_recipe(drafting, builder, recipe, START_SHARE);
            if known.is_none() {
                flowers.tell(raw_mm);
            }
        }
    }

    /// Builds the orders of the best drafts once more in finer voxels, and the best of these in still finer ones. A layout in
    /// voxels of edge `pitch` took the share `cost`.
    fn try_finer(&mut self, drafting: &mut Drafting<'_>, (cost, mut pitch): (f64, f64), until: f64) {
        let orders = |drafting: &Drafting<'_>| -> Vec<_> {
            drafting.drafts.iter().map(|draft| (draft.recipe, draft.order.clone())).collect()
        };
        let mut best = orders(drafting);
        for (level, count) in FINER_COUNTS.into_iter().enumerate() {
            best.truncate(count);
            if best.is_empty() {
                break;
            }
            let left = (until - self.spent_share()) / (FINER_COUNTS.len() - level) as f64;
            let Some(factor) = finer_voxels(left / best.len() as f64, cost) else { continue };
            let mut builder = LayoutBuilder::finer_by(drafting.task, factor);
            if builder.pitch > LEAST_REFINEMENT * pitch {
                break;
            }
            pitch = builder.pitch;
            let before = std::mem::take(&mut drafting.drafts);
            for order in best {
                self.try_order(drafting, &mut builder, order, START_SHARE);
            }
            best = orders(drafting);
            before.into_iter().for_each(|draft| drafting.keep(draft));
        }
    }
}
