//! The last step of a search. Improves the criteria that count after the height without increasing the height: parts
//! move down and towards the origin while every exact test passes. The packed box gets denser, and the build lies
//! nearer to the origin.

use std::cmp::Ordering;

use glam::DVec3;
use solids::Bounds;

use crate::{
    prepare::{
        layers::FilledLayers,
        prepared_instance::{PlacedItem, PreparedInstance, height_mm, item_layer_areas},
    },
    problem::fit_check::WALL_SPARE_MM,
};

/// Shorter moves are not tested, mm.
const MIN_MOVE_MM: f64 = 0.02;
/// Greatest number of rounds over all parts.
const ROUNDS: usize = 4;

/// The quality of a layout apart from the copies that it places, in order of importance. Evenness is compared last because
/// it costs more to compute.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LayoutMerit {
    /// Build height, mm: lower is better.
    height_mm: f64,
    /// Part volume over the volume of the packed box, which reaches from the origin to the farthest part: more is
    /// better.
    packed_density: f64,
    /// Mean distance of the parts' centers from the origin, mm: less is better.
    distance_mm: f64,
}

impl LayoutMerit {
    /// Measures pieces.
    fn from_items(prepared: &PreparedInstance, pieces: &[PlacedItem]) -> Self {
        let volume_mm3 = pieces.iter().map(|p| prepared.prepared_item(p.item).shape.tree.mesh().volume_mm3()).sum();
        let (packed_density, distance_mm) = packing_measures(volume_mm3, pieces.iter().map(|p| p.bounds));
        Self { height_mm: height_mm(pieces), packed_density, distance_mm }
    }

    /// Less is better: height first, then density, then closeness to the origin. Differences too small to measure are
    /// ignored.
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

/// Whether one layout is better than another one of the same copies: by height, then density of the packed box,
/// closeness to the origin, and evenness of the filled area per layer.
pub(crate) fn is_better_layout(prepared: &PreparedInstance, one: &[PlacedItem], other: &[PlacedItem]) -> bool {
    let evenness = |pieces: &[PlacedItem]| {
        let mut filled = FilledLayers::new(prepared.outlined.layer_cap);
        pieces.iter().for_each(|piece| filled.add_part(&item_layer_areas(prepared, piece)));
        filled.layer_areas().evenness
    };
    match LayoutMerit::from_items(prepared, one).compare(&LayoutMerit::from_items(prepared, other)) {
        Ordering::Equal => evenness(one) > evenness(other) + 1e-4,
        order => order.is_lt(),
    }
}

/// Part volume over the volume of the packed box, which reaches from the origin to the farthest part; and the mean
/// distance of the parts' centers from the origin.
pub(crate) fn packing_measures(volume_mm3: f64, bounds: impl Iterator<Item = Bounds> + Clone) -> (f64, f64) {
    let far = bounds.clone().fold(DVec3::ZERO, |far, b| far.max(b.max));
    let count = bounds.clone().count();
    if count == 0 {
        return (0.0, 0.0);
    }
    let distance_mm = bounds.map(|b| b.center().length()).sum::<f64>() / count as f64;
    (volume_mm3 / far.element_product(), distance_mm)
}

/// Moves parts down and towards the origin until no part moves any more or `over` returns true for the number of tests
/// made. The height and the packed box never grow, and no layer exceeds the cap. Returns the number of tests.
pub(crate) fn pack_toward_origin(
    prepared: &PreparedInstance,
    pieces: &mut [PlacedItem],
    over: impl Fn(u64) -> bool,
) -> u64 {
    let mut room = OriginPacking { prepared, filled: FilledLayers::new(prepared.outlined.layer_cap), tests: 0 };
    if room.filled.is_capped() {
        pieces.iter().for_each(|piece| room.filled.add_part(&item_layer_areas(prepared, piece)));
    }
    for _ in 0..ROUNDS {
        // The part nearest to the origin moves first: it makes room for those behind it.
        let mut order: Vec<usize> = (0..pieces.len()).collect();
        order.sort_by(|&a, &b| pieces[a].center.length().total_cmp(&pieces[b].center.length()).then(a.cmp(&b)));
        let mut moved = false;
        for part in order {
            for direction in [DVec3::Z, DVec3::Y, DVec3::X] {
                if over(room.tests) {
                    return room.tests;
                }
                moved |= room.slide_part(pieces, part, direction);
            }
        }
        if !moved {
            break;
        }
    }
    room.tests
}

/// A layout whose parts move towards the origin.
struct OriginPacking<'t> {
    prepared: &'t PreparedInstance,
    filled: FilledLayers,
    tests: u64,
}

impl OriginPacking<'_> {
    /// Moves a part against `direction` as far as possible, in steps that are halved after each failure. Returns whether it
    /// moved.
    fn slide_part(&mut self, pieces: &mut [PlacedItem], part: usize, direction: DVec3) -> bool {
        let here = &pieces[part];
        if self.prepared.is_fixed((here.item, here.copy)) {
            return false;
        }
        let free_mm = |piece: &PlacedItem| piece.bounds.min.dot(direction) - WALL_SPARE_MM;
        // Most parts cannot move at all.
        if free_mm(&pieces[part]) < MIN_MOVE_MM || !self.try_shift(pieces, part, -direction * MIN_MOVE_MM) {
            return false;
        }
        let mut step_mm = free_mm(&pieces[part]);
        while step_mm >= MIN_MOVE_MM {
            if !self.try_shift(pieces, part, -direction * step_mm) {
                step_mm *= 0.5;
            }
            step_mm = step_mm.min(free_mm(&pieces[part]));
        }
        true
    }

    /// Moves a part if it is clear at the new place.
    fn try_shift(&mut self, pieces: &mut [PlacedItem], part: usize, shift: DVec3) -> bool {
        self.tests += 1;
        let (prepared, piece) = (self.prepared, &pieces[part]);
        let moved = prepared.place_item((piece.item, piece.copy), piece.rotation, piece.center + shift);
        let others = pieces.iter().enumerate().filter(|&(other, _)| other != part);
        if !prepared.is_inside(&moved, prepared.room.z)
            || !others.clone().all(|(_, other)| prepared.is_clear(&moved, other))
        {
            return false;
        }
        if !prepared.zones.iter().all(|zone| prepared.is_clear(&moved, zone)) {
            return false;
        }
        if self.filled.is_capped() && shift.z != 0.0 {
            let (before, after) = (item_layer_areas(prepared, piece), item_layer_areas(prepared, &moved));
            self.filled.remove_part(&before);
            let takes = self.filled.can_add(&after);
            self.filled.add_part(if takes { &after } else { &before });
            if !takes {
                return false;
            }
        }
        pieces[part] = moved;
        true
    }
}
