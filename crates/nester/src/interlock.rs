//! What the search does about parts that are locked into each other: the pair is told to keep its hulls apart for a while,
//! its smaller part is moved elsewhere, and separation goes on as after any other failed check.

use rand_chacha::ChaCha8Rng;

use super::{
    layout::Layout,
    piece::{Piece, Task},
    relocate::{DepthGrid, Effort, move_away},
    separable::{dismantle, in_the_way, locked_pairs},
};

/// Sweeps that cost about as much as one evaluation of the search.
const SWEEPS_PER_EVALUATION: u64 = 2;

/// What finding another place for a locked part may cost.
const EFFORT: Effort = Effort { asked: 800, looked_at: 24, pushed: 3 };

/// Whether the layout that was just confirmed can be taken apart, or need not. Otherwise notes are made and parts moved, so
/// that going on leads elsewhere.
pub(crate) fn is_settled(
    layout: &mut Layout<'_>,
    pieces: &[Piece],
    grid: &mut DepthGrid,
    rng: &mut ChaCha8Rng,
) -> bool {
    if !layout.task.separable {
        return true;
    }
    let known = std::mem::take(&mut layout.locks.leaves);
    let found = dismantle(layout.task, pieces, &known);
    layout.locks.leaves = found.leaves;
    layout.evaluations += found.sweeps / SWEEPS_PER_EVALUATION + 1;
    if found.locked.is_empty() {
        return true;
    }
    let pairs = locked_pairs(layout.task, pieces, &found.locked);
    layout.evaluations += (found.locked.len() * found.locked.len()) as u64;
    let mut leaving: Vec<usize> = Vec::new();
    let volume = |part: usize| layout.guides[part].shape.tree.mesh().volume_mm3();
    let smaller = |parts: &[usize]| parts.iter().copied().min_by(|&a, &b| volume(a).total_cmp(&volume(b)));
    for &(one, other) in &pairs {
        leaving.extend(smaller(&[one, other]).filter(|part| !leaving.contains(part)));
    }
    let smallest = smaller(&found.locked);
    let fresh = pairs.iter().filter(|&&(one, other)| layout.keep_hulls_apart(one, other)).count();
    if fresh == 0 {
        // A group that no single pair locks, or a pair that is locked though it was told before.
        leaving.extend(smallest.filter(|part| !leaving.contains(part)));
    }
    for part in leaving {
        move_away(layout, grid, part, EFFORT, rng);
    }
    false
}

/// Splits a layout into pieces that can be taken apart and those, the smallest that do, that keep the others from it.
pub(crate) fn parted(task: &Task, mut pieces: Vec<Piece>) -> (Vec<Piece>, Vec<Piece>) {
    let dropped = in_the_way(task, &pieces);
    let dropped = dropped.into_iter().rev().map(|at| pieces.remove(at)).collect();
    (pieces, dropped)
}
