//! Handling of interlocked parts during the search: an interlocked pair keeps its hulls apart for a while, and so does the
//! smallest movable part of an interlocked group from the others; it is moved elsewhere, and separation continues as
//! after any other failed check.

use rand_chacha::ChaCha8Rng;

use super::{
    disassembly::{items_blocking_disassembly, locked_pairs},
    overlap_depth_grid::OverlapDepthGrid,
    relocation::{RelocationEffort, move_elsewhere},
    working_layout::WorkingLayout,
};
use crate::prepare::prepared_instance::{PlacedItem, PreparedInstance};

/// Number of sweep tests that cost about as much as one evaluation of the search.
const SWEEPS_PER_EVALUATION: u64 = 2;

/// Search effort for another place of a locked part.
const EFFORT: RelocationEffort = RelocationEffort { grid_queries: 800, coarse_checks: 24, separated: 3 };

/// Returns whether the layout that was just confirmed can be taken apart, or need not be. Otherwise remembers the
/// locked pairs, or the smallest movable part of a locked group with each of the others, and moves parts, so that
/// separation continues from a different layout.
pub(crate) fn resolve_interlocks(
    layout: &mut WorkingLayout<'_>,
    pieces: &[PlacedItem],
    grid: &mut OverlapDepthGrid,
    rng: &mut ChaCha8Rng,
) -> bool {
    if !layout.prepared.must_be_separable {
        return true;
    }
    let found = layout.take_apart(pieces);
    layout.evaluations += found.sweeps / SWEEPS_PER_EVALUATION + 1;
    if found.locked.is_empty() {
        return true;
    }
    let pairs = locked_pairs(layout.prepared, pieces, &found.locked);
    layout.evaluations += (found.locked.len() * found.locked.len()) as u64;
    let mut leaving: Vec<usize> = Vec::new();
    let volume = |part: usize| layout.proxies[part].shape.tree.mesh().volume_mm3();
    let smallest_movable = |parts: &[usize]| {
        let movable = parts.iter().copied().filter(|&part| !layout.parts.fixed[part]);
        movable.min_by(|&a, &b| volume(a).total_cmp(&volume(b)))
    };
    for &(one, other) in &pairs {
        leaving.extend(smallest_movable(&[one, other]).filter(|part| !leaving.contains(part)));
    }
    let smallest = smallest_movable(&found.locked);
    let fresh = pairs.iter().filter(|&&(one, other)| layout.keep_hulls_apart(one, other)).count();
    if let Some(part) = smallest.filter(|_| fresh == 0) {
        // A group in which no single pair is locked, or a pair that is locked although it was remembered before. Without a
        // memory of the group, the part would soon be back: no other place is as empty as the one that it left.
        for &other in found.locked.iter().filter(|&&other| other != part) {
            layout.keep_hulls_apart(part, other);
        }
        if !leaving.contains(&part) {
            leaving.push(part);
        }
    }
    for part in leaving {
        move_elsewhere(layout, grid, part, EFFORT, rng);
    }
    false
}

/// Splits a layout into pieces that can be taken apart and the smallest pieces that prevent it.
pub(crate) fn split_separable(
    prepared: &PreparedInstance,
    mut pieces: Vec<PlacedItem>,
) -> (Vec<PlacedItem>, Vec<PlacedItem>) {
    let dropped = items_blocking_disassembly(prepared, &pieces);
    let dropped = dropped.into_iter().rev().map(|at| pieces.remove(at)).collect();
    (pieces, dropped)
}
