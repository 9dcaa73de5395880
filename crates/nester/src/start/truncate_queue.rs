//! Truncates a queue of parts that is far too long for the volume: parts earlier in the queue are kept.

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

use super::{
    layout_builder::{LayoutBuilder, PartialLayout},
    nesting_run::NestingRun,
    recipe::PlacementRecipe,
};
use crate::{
    NestingInstance,
    prepare::prepared_instance::{PlacedItem, PreparedInstance},
};

/// No build of different parts has ever been this dense. A greater volume is not tried as a whole.
const MAX_DENSITY: f64 = 0.5;
/// Share of the build volume by which the queue is first advanced: about the share that stacked boxes fill.
const FIRST_ADVANCE: f64 = 0.08;

/// Whether the copies are too many to fit all together.
pub(super) fn exceeds_capacity(instance: &NestingInstance, copies: &[(usize, u32)]) -> bool {
    let volume_mm3: f64 = copies.iter().map(|&(item, _)| instance.items()[item].mesh.volume_mm3()).sum();
    volume_mm3 > MAX_DENSITY * instance.volume().size_mm.element_product()
}

impl NestingRun<'_> {
    /// Places the longest prefix of the queue that fits as a whole, then every later copy that still finds a gap, in
    /// order of precedence. The queue advances by groups: either all copies of a group are placed or none. Each group
    /// is sorted by size, which fills better. Groups get smaller as the volume fills up.
    pub(super) fn place_by_precedence(
        &mut self,
        prepared: &PreparedInstance,
        builder: &mut LayoutBuilder<'_>,
        standing: &[PlacedItem],
        missing: &[(usize, u32)],
    ) {
        let mut rng = ChaCha8Rng::seed_from_u64(self.config.seed);
        let recipe = PlacementRecipe::FIRST[0];
        let mut stack = builder.start_layout(standing);
        let mut at = 0;
        let mut group = self.first_group_size(missing);
        while at < missing.len() && group > 0 {
            let end = (at + group).min(missing.len());
            let order = recipe.sort_copies(&prepared.outlined, &missing[at..end], &mut rng);
            let before = stack.clone();
            if self.place_all(builder, &recipe, &order, &mut stack) {
                (at, group) = (end, group.min(missing.len() / 10).max(1));
            } else {
                stack = before;
                group /= 4;
            }
            if self.stop.spent_share_at(0) >= 1.0 {
                break;
            }
        }
        for &copy in &missing[at..] {
            if self.stop.spent_share_at(0) >= 1.0 {
                break;
            }
            self.place_all(builder, &recipe, &[copy], &mut stack);
        }
        self.accept_truncated(stack.items);
    }

    /// Number of copies from the front of the queue that surely fit together.
    fn first_group_size(&self, missing: &[(usize, u32)]) -> usize {
        let mut room_mm3 = FIRST_ADVANCE * self.instance.volume().size_mm.element_product();
        let fits = missing.iter().take_while(|&&(item, _)| {
            room_mm3 -= self.instance.items()[item].mesh.volume_mm3();
            room_mm3 >= 0.0
        });
        fits.count().max(1)
    }

    /// Places all copies in order and returns whether every copy was placed. Stops at the first copy that does not fit.
    fn place_all(
        &mut self,
        builder: &mut LayoutBuilder<'_>,
        recipe: &PlacementRecipe,
        order: &[(usize, u32)],
        stack: &mut PartialLayout,
    ) -> bool {
        // Only a clock may end this loop: which copies are kept must not depend on the evaluation budget.
        let all =
            order.iter().all(|&copy| self.stop.spent_share_at(0) < 1.0 && builder.place_copy(recipe, copy, stack));
        self.count_steps(builder);
        all
    }

    /// Accepts a truncated layout, unless the budget ended first and the best layout so far holds far more copies in
    /// another order.
    fn accept_truncated(&mut self, kept: Vec<PlacedItem>) {
        if 10 * kept.len() < 9 * self.best_items.len() && self.stop.spent_share_at(0) >= 1.0 {
            return;
        }
        self.best_items.clear();
        self.offer_layout(kept);
    }
}
