//! What happens when not all copies fit: the order of precedence decides which are in, and the search only where.
//!
//! The search places as many copies as it can, in whatever order fills best. This step then goes through the copies in
//! order of precedence. A copy that was left out is tried beside the copies before it, without those behind it. Where
//! it finds a place, the copies behind it keep theirs as far as they can, and the others are tried again in their
//! turn. So in the end, each copy that is left out was tried beside all that rank before it, at the very poses of the
//! result. Equal copies change places first, and one of them that found no place speaks for all behind it.

use std::{
    collections::{BTreeMap, hash_map::DefaultHasher},
    hash::{Hash, Hasher},
    sync::Arc,
};

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

use super::{
    box_stacker::BoxStacker,
    layout_builder::{LayoutBuilder, PartialLayout},
    nesting_run::NestingRun,
    recipe::PlacementRecipe,
};
use crate::{
    prepare::prepared_instance::{PlacedItem, PreparedInstance},
    separation::{disassembly::can_be_removed, interlock_check::split_separable},
    shapes::outline::OutlinedItem,
};

/// Number of left-out items per round for which everything before them is also placed anew. The others are inserted.
const MAX_REBUILT_ITEMS: usize = 4;
/// Greatest number of copies that are placed anew for a left-out one.
const MAX_REBUILT_COPIES: usize = 150;
/// Greatest number of rounds. Each round brings a copy in, or is the last.
const MAX_ROUNDS: usize = 30;
/// At least this number of rotations of a left-out copy is tried.
const MIN_ROTATIONS: usize = 12;
/// Share of the time, counted by a clock only, after which no more copies are tried,
const OVERTIME_SHARE: f64 = 1.5;
/// except for this number of left-out items of the highest precedence.
const MIN_TRIED_ITEMS: usize = 8;

/// A copy of an item.
type CopyIndex = (usize, u32);

/// How hard a place for a left-out copy is searched for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum InsertionEffort {
    /// Into a gap, or on top.
    Gap,
    /// The parts around the best place make room.
    MakeRoom,
    /// Everything is placed anew.
    Rebuild,
}

impl InsertionEffort {
    /// The effort for the next left-out item, after so many others of the same round.
    pub(crate) fn after_left_out(self, others: usize) -> Self {
        if others < MAX_REBUILT_ITEMS { self } else { self.min(Self::MakeRoom) }
    }
}

/// One pass through the copies in order of precedence.
struct PrecedenceRound<'t, 'b> {
    task: &'t PreparedInstance,
    builder: &'b mut LayoutBuilder<'t>,
    /// The copies so far that are in.
    stack: PartialLayout,
    /// The copies further back that were in before.
    behind: BTreeMap<CopyIndex, PlacedItem>,
    /// Items of which a copy found no place.
    left_out: Vec<usize>,
    /// Whether a copy came in, so that those behind it must be tested again.
    is_changed: bool,
    /// Whether each copy must be removable from among those before it.
    is_strict: bool,
}

impl NestingRun<'_> {
    /// Makes the best layout keep the order of precedence if not all copies are in: a copy is left out only if it
    /// found no place beside the copies before it. Only a clock may end this early: which copies are in must not depend
    /// on the evaluation budget.
    pub(crate) fn enforce_precedence(&mut self, task: &PreparedInstance, effort: InsertionEffort) {
        if self.best_items.len() == task.copies.len() || self.stop.spent_share_at(0).is_infinite() {
            return;
        }
        let mut builder = LayoutBuilder::new(task).with_rotations(MIN_ROTATIONS);
        let mut pieces = swap_equal_copies(task, std::mem::take(&mut self.best_items));
        pieces.sort_by_key(|piece| (piece.item, piece.copy));
        for _ in 0..MAX_ROUNDS {
            let round = (effort, false);
            let Some(mut better) = self.run_precedence_round(task, &mut builder, &pieces, round) else { break };
            if task.must_be_separable && !split_separable(task, better.clone()).1.is_empty() {
                let round = (effort, true);
                let Some(strict) = self.run_precedence_round(task, &mut builder, &pieces, round) else { break };
                better = strict;
            }
            pieces = swap_equal_copies(task, better);
            pieces.sort_by_key(|piece| (piece.item, piece.copy));
        }
        // Layouts with as many copies may hold other copies.
        self.first_layouts.clear();
        self.offer_layout(pieces);
    }

    /// Goes through all copies once. `None` = nothing changes.
    fn run_precedence_round<'t>(
        &mut self,
        task: &'t PreparedInstance,
        builder: &mut LayoutBuilder<'t>,
        pieces: &[PlacedItem],
        (effort, is_strict): (InsertionEffort, bool),
    ) -> Option<Vec<PlacedItem>> {
        let (pinned, free): (Vec<&PlacedItem>, Vec<&PlacedItem>) =
            pieces.iter().partition(|piece| task.is_fixed((piece.item, piece.copy)));
        let pinned: Vec<PlacedItem> = pinned.into_iter().cloned().collect();
        let mut round = PrecedenceRound {
            task,
            stack: builder.start_layout(&pinned),
            builder,
            behind: free.into_iter().map(|piece| ((piece.item, piece.copy), piece.clone())).collect(),
            left_out: Vec::new(),
            is_changed: false,
            is_strict,
        };
        for &copy in task.copies.iter().filter(|copy| !task.pinned.contains(copy)) {
            let stood = round.behind.remove(&copy);
            if stood.is_some_and(|piece| round.keep_standing(piece)) || round.is_equal_left_out(copy) {
                continue;
            }
            let effort = effort.after_left_out(round.left_out.len());
            if self.insert_before_others(&mut round, copy, effort) {
                round.is_changed = true;
            } else {
                round.left_out.push(copy.0);
            }
        }
        round.is_changed.then_some(round.stack.items)
    }

    /// Inserts a copy beside those before it; so that those behind it keep their places if possible.
    fn insert_before_others(
        &mut self,
        round: &mut PrecedenceRound<'_, '_>,
        copy: CopyIndex,
        effort: InsertionEffort,
    ) -> bool {
        let effort = match self.stop.spent_share_at(0) {
            share if share >= OVERTIME_SHARE && round.left_out.len() >= MIN_TRIED_ITEMS => return false,
            share if share >= 1.0 => InsertionEffort::Gap,
            // It is not overtaken: the search has tried it beside all others.
            _ if round.behind.is_empty() => InsertionEffort::Gap,
            _ => effort,
        };
        let before = round.stack.clone();
        let placed = round.builder.place_copy(&PlacementRecipe::FIRST[0], copy, &mut round.stack);
        self.count_steps(round.builder);
        if placed {
            round.spare_those_behind(copy, before);
            self.count_steps(round.builder);
            return true;
        }
        match self.rearrange_before(round.task, round.builder, &round.stack.items, copy, effort) {
            Some(pieces) => round.stack = round.builder.start_layout(&pieces),
            None => return false,
        }
        true
    }

    /// Whether a copy finds a place beside these pieces, or was never tried there. Tests ask this of a result.
    /// Thoroughly, it is tried once more.
    #[cfg(test)]
    pub(crate) fn fits_beside(
        &mut self,
        task: &PreparedInstance,
        pieces: &[PlacedItem],
        copy: CopyIndex,
        effort: InsertionEffort,
        is_thorough: bool,
    ) -> bool {
        let mut builder = LayoutBuilder::new(task).with_rotations(MIN_ROTATIONS);
        let mut stack = builder.start_layout(pieces);
        if builder.place_copy(&PlacementRecipe::FIRST[0], copy, &mut stack) {
            return true;
        }
        if is_thorough {
            self.failed_insertions.clear();
        }
        let known = self.failed_insertions.len();
        let found = self.rearrange_before(task, &mut builder, pieces, copy, effort).is_some();
        found || !is_thorough && self.failed_insertions.len() > known
    }

    /// Searches for a layout of these pieces with one more copy, for which there is no gap. What failed once is not
    /// tried again.
    fn rearrange_before<'t>(
        &mut self,
        task: &'t PreparedInstance,
        builder: &mut LayoutBuilder<'t>,
        pieces: &[PlacedItem],
        copy: CopyIndex,
        effort: InsertionEffort,
    ) -> Option<Vec<PlacedItem>> {
        let volume_mm3 = |piece: &PlacedItem| task.outlined.outlined_item(piece.item).mesh.volume_mm3();
        let more_mm3 = task.outlined.outlined_item(copy.0).mesh.volume_mm3();
        let is_too_much = pieces.iter().map(volume_mm3).sum::<f64>() + more_mm3 > task.room.element_product();
        if effort < InsertionEffort::MakeRoom || pieces.is_empty() || is_too_much {
            return None;
        }
        let stop = self.stop;
        let mut more = pieces.to_vec();
        let turn = task.outlined.outlined_item(copy.0).fitting_rotation;
        more.push(task.place_item(copy, turn, 0.5 * task.room));
        if self.failed_insertions.insert(hash_of_pieces(&more, true)) {
            let is_over = |_: u64| stop.spent_share_at(0) >= 1.0;
            let mut rng = ChaCha8Rng::seed_from_u64(self.config.seed);
            let found = self.make_room(task, &more, task.room.z, &mut rng, &is_over);
            if found.is_some() {
                return found;
            }
        }
        let is_worthwhile = effort == InsertionEffort::Rebuild && more.len() <= MAX_REBUILT_COPIES;
        if is_worthwhile && self.failed_insertions.insert(hash_of_pieces(&more, false)) {
            return self.rebuild_all(task, builder, &more);
        }
        None
    }

    /// Places pieces anew in several orders, until all of them are in.
    fn rebuild_all<'t>(
        &mut self,
        task: &'t PreparedInstance,
        builder: &mut LayoutBuilder<'t>,
        pieces: &[PlacedItem],
    ) -> Option<Vec<PlacedItem>> {
        let stop = self.stop;
        let (pinned, free): (Vec<&PlacedItem>, Vec<&PlacedItem>) =
            pieces.iter().partition(|piece| task.is_fixed((piece.item, piece.copy)));
        let pinned: Vec<PlacedItem> = pinned.into_iter().cloned().collect();
        let copies: Vec<CopyIndex> = free.iter().map(|piece| (piece.item, piece.copy)).collect();
        let mut rng = ChaCha8Rng::seed_from_u64(self.config.seed);
        for recipe in PlacementRecipe::FIRST {
            let order = recipe.sort_copies(&task.outlined, &copies, &mut rng);
            let stacked = BoxStacker::new(&task.outlined).stack_copies(&pinned, &order);
            if stacked.len() == pieces.len() {
                return Some(stacked);
            }
            let built = builder.build_separable(&recipe, &order, &pinned, &mut |_| stop.spent_share_at(0) >= 1.0);
            self.count_steps(builder);
            if let Some(built) = built.filter(|built| built.len() == pieces.len()) {
                return Some(built);
            }
        }
        None
    }
}

impl PrecedenceRound<'_, '_> {
    /// Keeps a copy where it stood, if its place is still free. Returns whether it is.
    fn keep_standing(&mut self, piece: PlacedItem) -> bool {
        let is_free = !self.is_changed
            || self.stack.can_take(self.task, &piece)
                && (!self.is_strict || can_be_removed(self.task, &piece, &self.stack.items));
        if is_free {
            self.builder.add_standing(&mut self.stack, piece);
        }
        is_free
    }

    /// Whether an equal copy found no place before.
    fn is_equal_left_out(&self, copy: CopyIndex) -> bool {
        let lineup = &self.task.outlined;
        let one = lineup.outlined_item(copy.0);
        self.left_out.iter().any(|&item| are_equal(one, lineup.outlined_item(item)))
    }

    /// The copy that was placed last may stand where others stood. Looks for a place of it that puts out fewer of
    /// them, beginning with those of least precedence. `before` is the layout without the copy.
    fn spare_those_behind(&mut self, copy: CopyIndex, before: PartialLayout) {
        let is_in_the_way = |piece: &PlacedItem, other: &PlacedItem| !self.task.is_clear(piece, other);
        let Some(placed) = self.stack.items.last() else { return };
        if !self.behind.values().any(|other| is_in_the_way(placed, other)) {
            return;
        }
        let behind: Vec<&PlacedItem> = self.behind.values().collect();
        let mut put_out = 0;
        while put_out < behind.len() {
            let mut stack = before.clone();
            for &piece in &behind[..behind.len() - put_out] {
                self.builder.add_standing(&mut stack, piece.clone());
            }
            if self.builder.place_copy(&PlacementRecipe::FIRST[0], copy, &mut stack)
                && let Some(piece) = stack.items.pop()
            {
                self.stack = before;
                return self.builder.add_standing(&mut self.stack, piece);
            }
            put_out = 2 * put_out + 1;
        }
    }
}

/// Names the copies of a layout, and their places too if wanted.
fn hash_of_pieces(pieces: &[PlacedItem], with_places: bool) -> u64 {
    let mut hasher = DefaultHasher::new();
    with_places.hash(&mut hasher);
    for piece in pieces {
        (piece.item, piece.copy).hash(&mut hasher);
        if with_places {
            let place = piece.center.to_array().into_iter().chain(piece.rotation.to_array());
            place.for_each(|number| number.to_bits().hash(&mut hasher));
        }
    }
    hasher.finish()
}

/// Whether copies of two items can stand in for each other.
fn are_equal(one: &OutlinedItem, other: &OutlinedItem) -> bool {
    Arc::ptr_eq(&one.mesh, &other.mesh)
        && one.orientation == other.orientation
        && one.clearance_mm == other.clearance_mm
}

/// Gives the places of equal copies to those of highest precedence among them.
fn swap_equal_copies(task: &PreparedInstance, mut pieces: Vec<PlacedItem>) -> Vec<PlacedItem> {
    let mut placed: BTreeMap<CopyIndex, usize> =
        pieces.iter().enumerate().map(|(at, piece)| ((piece.item, piece.copy), at)).collect();
    for &copy in task.copies.iter().filter(|copy| !task.pinned.contains(copy)) {
        if placed.contains_key(&copy) {
            continue;
        }
        let one = task.outlined.outlined_item(copy.0);
        let equals =
            |other: &CopyIndex| !task.pinned.contains(other) && are_equal(one, task.outlined.outlined_item(other.0));
        if let Some((&last, &at)) = placed.range(copy..).rev().find(|(other, _)| equals(other)) {
            (pieces[at].item, pieces[at].copy) = copy;
            placed.remove(&last);
            placed.insert(copy, at);
        }
    }
    pieces
}
