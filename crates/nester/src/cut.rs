//! A line of parts far too long for the volume is cut: whoever stands further ahead stays.

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

use super::{
    Instance,
    construct::{Builder, Stack},
    course::{Course, TESTS_PER_EVALUATION},
    piece::{Piece, Task},
    recipe::Recipe,
};

/// No build of different parts has ever been this dense: what is more than that need not be tried whole.
const DENSEST: f64 = 0.5;
/// Share of the room's volume by which the line is first advanced: about what boxes fill.
const FIRST_ADVANCE: f64 = 0.08;

/// Whether copies are so many that they cannot all find a place.
pub(super) fn is_hopeless(instance: &Instance, copies: &[(usize, u32)]) -> bool {
    let volume_mm3: f64 = copies.iter().map(|&(item, _)| instance.items()[item].mesh.volume_mm3()).sum();
    volume_mm3 > DENSEST * instance.volume().size_mm.element_product()
}

impl Course<'_> {
    /// The longest beginning of the line that fits whole, then whoever still finds a gap, in order of precedence. The line
    /// advances by groups: all of a group find a place or none stays. Groups are sorted by size, which fills better; they
    /// get smaller as the volume gets full.
    pub(super) fn keep_precedence(
        &mut self,
        task: &Task,
        builder: &mut Builder<'_>,
        standing: &[Piece],
        lacking: &[(usize, u32)],
    ) {
        let mut rng = ChaCha8Rng::seed_from_u64(self.config.seed);
        let recipe = Recipe::FIRST[0];
        let mut stack = builder.stack(standing);
        let mut at = 0;
        let mut group = self.first_group(lacking);
        while at < lacking.len() && group > 0 {
            let end = (at + group).min(lacking.len());
            let order = recipe.sorted(&task.lineup, &lacking[at..end], &mut rng);
            let before = stack.clone();
            if self.put_all(builder, &recipe, &order, &mut stack) {
                (at, group) = (end, group.min(lacking.len() / 10).max(1));
            } else {
                stack = before;
                group /= 4;
            }
            if self.stop.spent(0) >= 1.0 {
                break;
            }
        }
        for &copy in &lacking[at..] {
            if self.stop.spent(0) >= 1.0 {
                break;
            }
            self.put_all(builder, &recipe, &[copy], &mut stack);
        }
        self.settle(stack.pieces);
    }

    /// How many copies from the front of the line surely find a place together.
    fn first_group(&self, lacking: &[(usize, u32)]) -> usize {
        let mut room_mm3 = FIRST_ADVANCE * self.instance.volume().size_mm.element_product();
        let fits = lacking.iter().take_while(|&&(item, _)| {
            room_mm3 -= self.instance.items()[item].mesh.volume_mm3();
            room_mm3 >= 0.0
        });
        fits.count().max(1)
    }

    /// Whether every copy found a place; ends at the first that does not.
    fn put_all(
        &mut self,
        builder: &mut Builder<'_>,
        recipe: &Recipe,
        order: &[(usize, u32)],
        stack: &mut Stack,
    ) -> bool {
        // Only a clock may end this: who stays must not depend on how many evaluations were asked for.
        let all = order.iter().all(|&copy| self.stop.spent(0) < 1.0 && builder.put(recipe, copy, stack));
        self.evaluations += builder.tests / TESTS_PER_EVALUATION;
        builder.tests %= TESTS_PER_EVALUATION;
        all
    }

    /// Takes a cut layout, unless the budget ended before it: then a far fuller one in another order is worth more than a
    /// short beginning.
    fn settle(&mut self, kept: Vec<Piece>) {
        if 10 * kept.len() < 9 * self.best.len() && self.stop.spent(0) >= 1.0 {
            return;
        }
        self.best.clear();
        self.offer(kept);
    }
}
