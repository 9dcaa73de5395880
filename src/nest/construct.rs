//! The start: one part after the other at its lowest place. Boxes on boxes always work and are the floor; bit columns do
//! better. Every placement is confirmed on the triangles before it counts.

use std::{
    cmp::Reverse,
    collections::{BTreeMap, BTreeSet},
};

use glam::{DQuat, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{
    interlock::parted,
    piece::{CLEARANCE_SPARE_MM, Piece, Task},
    separable::can_leave,
    skyline::Skyline,
    turns,
    voxels::{Occupancy, Raster},
};
use crate::pollination::{Edge, Gene};

/// How parts are taken and where they like to stand.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Recipe {
    /// 0 volume of the box, 1 longest edge, 2 largest face, 3 shortest edge.
    pub(crate) order: usize,
    /// Share of the part's height in the score: 1 = lowest top, 0 = lowest bottom.
    pub(crate) top_share: f64,
    /// Pull towards x = 0 rather than y = 0.
    pub(crate) pull_x: f64,
    /// Random factor on the sizes, 0 = none.
    pub(crate) shuffle: f64,
}

impl Recipe {
    /// The recipes that are tried before any others.
    pub(crate) const FIRST: [Self; 4] = [
        Self { order: 0, top_share: 1.0, pull_x: 0.5, shuffle: 0.0 },
        Self { order: 1, top_share: 0.8, pull_x: 0.9, shuffle: 0.0 },
        Self { order: 2, top_share: 1.0, pull_x: 0.1, shuffle: 0.0 },
        Self { order: 3, top_share: 0.6, pull_x: 0.9, shuffle: 0.0 },
    ];

    /// The ranges of a genome that stands for a recipe.
    pub(crate) fn genes() -> Vec<Gene> {
        let gene = |upper: f64| Gene { lower: 0.0, upper, edge: Edge::Reflect };
        vec![gene(3.99), gene(1.0), gene(1.0), gene(0.6)]
    }

    /// The recipe that a genome stands for.
    pub(crate) fn of_genes(genome: &[f64]) -> Self {
        Self { order: genome[0] as usize, top_share: genome[1], pull_x: genome[2], shuffle: genome[3] }
    }

    /// Copies in the order of this recipe, largest first; equal ones stay together.
    pub(crate) fn sorted(&self, task: &Task, copies: &[(usize, u32)], rng: &mut ChaCha8Rng) -> Vec<(usize, u32)> {
        let mut sizes: BTreeMap<usize, i64> = BTreeMap::new();
        for &(item, _) in copies {
            sizes.entry(item).or_insert_with(|| {
                let size = 2.0 * task.kind(item).shape.tree.obb().half_mm;
                let (short, long) = (size.min_element(), size.max_element());
                let middle = size.element_sum() - short - long;
                let key = [short * middle * long, long, middle * long, short][self.order];
                (key * (1.0 + self.shuffle * rng.random_range(-1.0..1.0)) * 1e3) as i64
            });
        }
        let mut sorted = copies.to_vec();
        sorted.sort_by_key(|&(item, copy)| (Reverse(sizes[&item]), item, copy));
        sorted
    }
}

/// A copy of each piece where boxes alone put it; those that find no place are left out.
pub(crate) fn boxes(task: &Task, copies: &[(usize, u32)], standing: &[Piece]) -> Vec<Piece> {
    let mut pieces = standing.to_vec();
    let mut skyline = Skyline::new(task.room, 20_000.0);
    standing.iter().for_each(|p| skyline.add(&p.bounds));
    for &copy in copies {
        pieces.extend(on_top(task, copy, &mut skyline));
    }
    pieces
}

/// Stands a copy on whatever boxes are below it: always valid, never asks for shapes.
fn on_top(task: &Task, copy: (usize, u32), skyline: &mut Skyline) -> Option<Piece> {
    let turns = turns_of(task, copy.0, 6);
    let mut best: Option<(f64, Piece)> = None;
    for turn in turns {
        let lying = task.piece(copy, turn, DVec3::ZERO);
        let Some(corner) = skyline.lowest(lying.bounds.size(), task.reach_mm + CLEARANCE_SPARE_MM) else { continue };
        let top = corner.z + lying.bounds.size().z;
        if best.as_ref().is_none_or(|(least, _)| top < least - 1e-9) {
            let piece = task.piece(copy, turn, corner - lying.bounds.min);
            if task.is_inside(&piece, task.room.z) {
                best = Some((top, piece));
            }
        }
    }
    let (_, piece) = best?;
    skyline.add(&piece.bounds);
    Some(piece)
}

/// Rotations to try for an item; never empty.
fn turns_of(task: &Task, item: usize, most: usize) -> Vec<DQuat> {
    let kind = task.kind(item);
    let room = task.room - 2.0 * super::fit::WALL_SPARE_MM;
    let mut turns = turns::first_turns(kind.rule, kind.shape.frame, &kind.shape.extremes, room, most);
    if turns.is_empty() {
        turns.push(kind.fitting);
    }
    turns
}

/// Rasters of all items at all rotations tried, made when first needed and kept over all runs.
pub(crate) struct Builder<'t> {
    task: &'t Task,
    pitch: f64,
    turns: usize,
    rasters: BTreeMap<usize, Vec<Raster>>,
    /// Whether a place counts only where the part can be drawn out again.
    must_leave: bool,
    /// Placement tests made.
    pub(crate) tests: u64,
}

/// Voxels that a part is grown by beyond half its clearance: less wastes less, but fails the exact test more often.
const GROW: f64 = 0.45;

/// Places on the lattice that the triangles may refuse before a part goes on top.
const MOST_FAILED: usize = 8;
/// Places that may turn out to lock the part before it goes on top.
const MOST_HELD: usize = 24;

impl<'t> Builder<'t> {
    /// A builder whose lattice suits the task: finer for few parts and large clearances.
    pub(crate) fn new(task: &'t Task) -> Self {
        let distinct = task.kinds.iter().flatten().count().max(1);
        let columns = if task.copies.len() > 150 { 14_000.0 } else { 20_000.0 };
        let pitch = (task.room.x * task.room.y / columns).sqrt().max(0.3 * task.reach_mm).max(0.5);
        let turns = (300 / distinct).clamp(4, 16);
        Self { task, pitch, turns, rasters: BTreeMap::new(), must_leave: false, tests: 0 }
    }

    /// Places copies in the given order around what stands already; those that find no place are left out. Ends early
    /// with `None` when the layout gets as high as `worst_mm` or `enough` says so. Where no part may be locked, those that
    /// are find other places in the end.
    pub(crate) fn build(
        &mut self,
        recipe: &Recipe,
        order: &[(usize, u32)],
        standing: &[Piece],
        worst_mm: f64,
        mut enough: impl FnMut(u64) -> bool,
    ) -> Option<Vec<Piece>> {
        self.must_leave = false;
        let pieces = self.build_once(recipe, order, standing, worst_mm, &mut enough)?;
        if !self.task.separable {
            return Some(pieces);
        }
        let (kept, dropped) = parted(self.task, pieces);
        if dropped.is_empty() {
            return Some(kept);
        }
        let again: BTreeSet<(usize, u32)> = dropped.iter().map(|p| (p.item, p.copy)).collect();
        let again: Vec<(usize, u32)> = order.iter().copied().filter(|copy| again.contains(copy)).collect();
        self.must_leave = true;
        self.build_once(recipe, &again, &kept, f64::INFINITY, &mut enough)
    }

    /// One run over copies in order, around what stands.
    fn build_once(
        &mut self,
        recipe: &Recipe,
        order: &[(usize, u32)],
        standing: &[Piece],
        worst_mm: f64,
        enough: &mut impl FnMut(u64) -> bool,
    ) -> Option<Vec<Piece>> {
        let task = self.task;
        let mut occupancy = Occupancy::new(task.room, task.reach_mm, self.pitch);
        let mut skyline = Skyline::new(task.room, 20_000.0);
        let mut pieces = standing.to_vec();
        for piece in standing {
            let reach = 0.5 * task.reach_mm + GROW * self.pitch;
            let shape = &task.kind(piece.item).shape;
            occupancy.fill_solid(shape, &piece.pose, &piece.bounds, reach, 0.5 * task.reach_mm);
            skyline.add(&piece.bounds);
        }
        let mut floors = Floors::default();
        for &copy in order {
            if enough(self.tests) {
                return None;
            }
            let placed = self.place(recipe, copy, &mut occupancy, &pieces, &mut floors);
            let piece = match placed {
                Some(piece) => piece,
                None => {
                    let Some(piece) = on_top(task, copy, &mut skyline) else { continue };
                    let reach = 0.5 * task.reach_mm + GROW * self.pitch;
                    let shape = &task.kind(piece.item).shape;
                    occupancy.fill_solid(shape, &piece.pose, &piece.bounds, reach, 0.5 * task.reach_mm);
                    piece
                }
            };
            skyline.add(&piece.bounds);
            if piece.bounds.max.z >= worst_mm {
                return None;
            }
            pieces.push(piece);
        }
        Some(pieces)
    }

    /// The best place on the lattice that the triangles confirm.
    fn place(
        &mut self,
        recipe: &Recipe,
        copy: (usize, u32),
        occupancy: &mut Occupancy,
        pieces: &[Piece],
        floors: &mut Floors,
    ) -> Option<Piece> {
        let (task, pitch) = (self.task, self.pitch);
        let rasters = self.rasters.entry(copy.0).or_insert_with(|| {
            let turns = turns_of(task, copy.0, self.turns);
            let shape = &task.kind(copy.0).shape;
            turns.into_iter().map(|turn| Raster::new(shape, turn, task.reach_mm, pitch, GROW)).collect()
        });
        floors.turn_to(copy.0, rasters.len());
        let (mut failed, mut held) = (0, 0);
        while failed < MOST_FAILED && held < MOST_HELD {
            let (at, node) = lowest_score(recipe, occupancy, rasters, floors, &mut self.tests)?;
            let raster = &rasters[at];
            let piece = task.piece(copy, raster.turn, occupancy.place(raster, node));
            if !(task.is_inside(&piece, task.room.z) && pieces.iter().all(|other| task.is_clear(&piece, other))) {
                floors.forbid(at, node);
                failed += 1;
            // When each can leave those before it, all can leave in the opposite order.
            } else if self.must_leave && !can_leave(task, &piece, pieces) {
                let reach = 0.25 * task.kind(copy.0).shape.radius_mm / pitch;
                floors.forbid_around(node, reach.ceil() as usize);
                held += 1;
            } else {
                occupancy.fill(raster, node);
                return Some(piece);
            }
        }
        None
    }
}

/// The lowest layer known to be worth asking, for every position of every raster of one item: places only fill up.
#[derive(Default)]
struct Floors {
    item: Option<usize>,
    layers: Vec<Vec<u16>>,
    counts: Vec<usize>,
}

impl Floors {
    fn turn_to(&mut self, item: usize, rasters: usize) {
        if self.item != Some(item) {
            *self = Self { item: Some(item), layers: vec![Vec::new(); rasters], counts: vec![0; rasters] };
        }
    }

    fn forbid(&mut self, at: usize, [x, y, z]: [usize; 3]) {
        let count = self.counts[at];
        self.layers[at][x * count + y] = z as u16 + 1;
    }

    /// The part would be locked here, and so near, whatever its rotation.
    fn forbid_around(&mut self, [x, y, z]: [usize; 3], reach: usize) {
        let low = z.saturating_sub(reach);
        for (layers, &count) in self.layers.iter_mut().zip(&self.counts).filter(|(layers, _)| !layers.is_empty()) {
            for x in x.saturating_sub(reach)..=(x + reach).min(layers.len() / count - 1) {
                for y in y.saturating_sub(reach)..=(y + reach).min(count - 1) {
                    let layer = &mut layers[x * count + y];
                    if usize::from(*layer) >= low {
                        *layer = (*layer).max((z + reach + 1) as u16);
                    }
                }
            }
        }
    }
}

/// The raster and lattice position with the least score.
fn lowest_score(
    recipe: &Recipe,
    occupancy: &Occupancy,
    rasters: &[Raster],
    floors: &mut Floors,
    tests: &mut u64,
) -> Option<(usize, [usize; 3])> {
    let mut best: Option<(f64, usize, [usize; 3])> = None;
    for (at, raster) in rasters.iter().enumerate() {
        let Some([nx, ny, nz]) = occupancy.positions(raster) else { continue };
        if floors.layers[at].is_empty() {
            floors.layers[at] = vec![0; nx * ny];
            floors.counts[at] = ny;
        }
        let height = recipe.top_share * raster.size.z / occupancy.pitch;
        for x in 0..nx {
            for y in 0..ny {
                let pull = 0.01 * (recipe.pull_x * x as f64 + (1.0 - recipe.pull_x) * y as f64);
                let least = best.map_or(f64::INFINITY, |(score, ..)| score);
                let end = if least.is_finite() { (least - height - pull).ceil().max(0.0) as usize } else { nz };
                let floor = &mut floors.layers[at][x * ny + y];
                if usize::from(*floor) >= end.min(nz) {
                    continue;
                }
                *tests += 1;
                let found = occupancy.lowest(raster, [x, y], usize::from(*floor), end.min(nz));
                *floor = found.unwrap_or(end.min(nz)) as u16;
                if let Some(z) = found {
                    let score = z as f64 + height + pull;
                    if score < least {
                        best = Some((score, at, [x, y, z]));
                    }
                }
            }
        }
    }
    best.map(|(_, at, node)| (at, node))
}
