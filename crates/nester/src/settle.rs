//! The end of a search. The height stands; what comes after it is improved without ever giving any of it back: parts move
//! exactly, down and towards the origin, as long as everything stays clear. So the packed box gets denser, and the build
//! stands nearer to the origin.

use std::cmp::Ordering;

use glam::DVec3;
use solids::Bounds;

use super::{
    fit::WALL_SPARE_MM,
    layers::Filled,
    piece::{Piece, Task, height_mm, slice},
};

/// Shorter moves are not worth a question, mm.
const LEAST_MOVE_MM: f64 = 0.02;
/// Rounds over all parts at most.
const ROUNDS: usize = 4;

/// What a layout is worth beside the copies that it places, in order of precedence; evenness, which costs more to know,
/// comes after it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Merit {
    /// Build height, mm: less is better.
    height_mm: f64,
    /// Part volume over the volume of the packed box, which reaches from the origin to the farthest of all parts: more is
    /// better.
    packed_density: f64,
    /// Mean distance of the parts' middles from the origin, mm: less is better.
    distance_mm: f64,
}

impl Merit {
    /// Of pieces.
    fn of(task: &Task, pieces: &[Piece]) -> Self {
        let volume_mm3 = pieces.iter().map(|p| task.kind(p.item).shape.tree.mesh().volume_mm3()).sum();
        let (packed_density, distance_mm) = packing(volume_mm3, pieces.iter().map(|p| p.bounds));
        Self { height_mm: height_mm(pieces), packed_density, distance_mm }
    }

    /// Less is better: height first, then density, then closeness to the origin. Differences that nobody could measure do
    /// not decide.
    fn compare(&self, other: &Self) -> Ordering {
        let first = |one: f64, two: f64, least: f64| match (one - two).abs() < least {
            true => Ordering::Equal,
            false => one.total_cmp(&two),
        };
        first(self.height_mm, other.height_mm, 1e-6)
            .then(first(other.packed_density, self.packed_density, 1e-6))
            .then(first(self.distance_mm, other.distance_mm, 1e-4))
    }
}

/// Whether one layout of the same copies is worth more than another: height, then density of the packed box, closeness to
/// the origin, evenness of the filled area per layer.
pub(crate) fn is_better(task: &Task, one: &[Piece], other: &[Piece]) -> bool {
    let evenness = |pieces: &[Piece]| {
        let mut filled = Filled::new(task.lineup.cap);
        pieces.iter().for_each(|piece| filled.add(&slice(task, piece)));
        filled.areas().evenness
    };
    match Merit::of(task, one).compare(&Merit::of(task, other)) {
        Ordering::Equal => evenness(one) > evenness(other) + 1e-4,
        order => order.is_lt(),
    }
}

/// Part volume over the volume of the packed box, which reaches from the origin to the farthest of all parts, and the mean
/// distance of the parts' middles from the origin.
pub(crate) fn packing(volume_mm3: f64, bounds: impl Iterator<Item = Bounds> + Clone) -> (f64, f64) {
    let far = bounds.clone().fold(DVec3::ZERO, |far, b| far.max(b.max));
    let count = bounds.clone().count();
    if count == 0 {
        return (0.0, 0.0);
    }
    let distance_mm = bounds.map(|b| b.center().length()).sum::<f64>() / count as f64;
    (volume_mm3 / far.element_product(), distance_mm)
}

/// Moves parts down and towards the origin until nothing moves any more or `over` says so after so many questions. The
/// height never grows, the packed box neither, and no layer is filled beyond the cap. Returns how many questions it asked.
pub(crate) fn settle(task: &Task, pieces: &mut [Piece], over: impl Fn(u64) -> bool) -> u64 {
    let mut room = Settling { task, filled: Filled::new(task.lineup.cap), asked: 0 };
    if room.filled.is_capped() {
        pieces.iter().for_each(|piece| room.filled.add(&slice(task, piece)));
    }
    for _ in 0..ROUNDS {
        // Who stands nearest goes first: it makes room for those behind it.
        let mut order: Vec<usize> = (0..pieces.len()).collect();
        order.sort_by(|&a, &b| pieces[a].place.length().total_cmp(&pieces[b].place.length()).then(a.cmp(&b)));
        let mut moved = false;
        for part in order {
            for way in [DVec3::Z, DVec3::Y, DVec3::X] {
                if over(room.asked) {
                    return room.asked;
                }
                moved |= room.draw(pieces, part, way);
            }
        }
        if !moved {
            break;
        }
    }
    room.asked
}

/// A layout that settles.
struct Settling<'t> {
    task: &'t Task,
    filled: Filled,
    asked: u64,
}

impl Settling<'_> {
    /// Moves a part against `way` as far as steps that halve can take it. Returns whether it moved.
    fn draw(&mut self, pieces: &mut [Piece], part: usize, way: DVec3) -> bool {
        let here = &pieces[part];
        if self.task.is_fixed((here.item, here.copy)) {
            return false;
        }
        let free_mm = |piece: &Piece| piece.bounds.min.dot(way) - WALL_SPARE_MM;
        // Most parts cannot move at all.
        if free_mm(&pieces[part]) < LEAST_MOVE_MM || !self.step(pieces, part, -way * LEAST_MOVE_MM) {
            return false;
        }
        let mut step_mm = free_mm(&pieces[part]);
        while step_mm >= LEAST_MOVE_MM {
            if !self.step(pieces, part, -way * step_mm) {
                step_mm *= 0.5;
            }
            step_mm = step_mm.min(free_mm(&pieces[part]));
        }
        true
    }

    /// Moves a part when it is clear there.
    fn step(&mut self, pieces: &mut [Piece], part: usize, shift: DVec3) -> bool {
        self.asked += 1;
        let (task, piece) = (self.task, &pieces[part]);
        let moved = task.piece((piece.item, piece.copy), piece.turn, piece.place + shift);
        let others = pieces.iter().enumerate().filter(|&(other, _)| other != part);
        if !task.is_inside(&moved, task.room.z) || !others.clone().all(|(_, other)| task.is_clear(&moved, other)) {
            return false;
        }
        if !task.zones.iter().all(|zone| task.is_clear(&moved, zone)) {
            return false;
        }
        if self.filled.is_capped() && shift.z != 0.0 {
            let (before, after) = (slice(task, piece), slice(task, &moved));
            self.filled.take(&before);
            let takes = self.filled.takes(&after);
            self.filled.add(if takes { &after } else { &before });
            if !takes {
                return false;
            }
        }
        pieces[part] = moved;
        true
    }
}
