//! The start: one part after the other at its lowest place in bit columns; on top of all others where it finds none. Every
//! placement is confirmed on the triangles before it counts.

use std::collections::{BTreeMap, BTreeSet};

use super::{
    boxes::{Boxes, turns_of},
    interlock::parted,
    layers::Filled,
    near::Near,
    piece::{Piece, Task, lifted, slice},
    recipe::Recipe,
    scan::Floors,
    separable::can_leave,
    skyline::Skyline,
    voxels::{Occupancy, Raster},
};

/// Voxels that a part is grown by beyond half its clearance: less wastes less, but fails the exact test more often.
const GROW: f64 = 0.45;
/// What is known of places that are taken, in memory at most, bytes.
const MOST_FLOORS: usize = 64 << 20;
/// Places that are tried on the triangles before a part goes on top of all others.
const TRIES: usize = 8;
/// Places that may turn out to lock the part before it goes on top.
const MOST_HELD: usize = 6;
/// Rotations that wait for layers with room in them before a part goes on top of all others.
const RAISES: usize = 64;

/// Rasters of all items at all rotations tried, made when first needed and kept over all runs.
pub(crate) struct Builder<'t> {
    task: &'t Task,
    boxes: Boxes<'t>,
    pitch: f64,
    turns: usize,
    rasters: BTreeMap<usize, Vec<Raster>>,
    /// Whether a place counts only where the part can be drawn out again.
    must_leave: bool,
    /// Placement tests made.
    pub(crate) tests: u64,
}

/// A layout that is being built.
#[derive(Clone)]
pub(crate) struct Stack {
    pub(crate) pieces: Vec<Piece>,
    occupancy: Occupancy,
    skyline: Skyline,
    near: Near,
    floors: BTreeMap<usize, Floors>,
    filled: Filled,
}

impl<'t> Builder<'t> {
    /// A builder whose lattice suits the task: finer for few parts and large clearances.
    pub(crate) fn new(task: &'t Task) -> Self {
        let distinct = task.kinds.iter().flatten().count().max(1);
        let columns = if task.copies.len() > 150 { 14_000.0 } else { 20_000.0 };
        let pitch = (task.room.x * task.room.y / columns).sqrt().max(0.3 * task.reach_mm).max(0.5);
        let turns = (300 / distinct).clamp(4, 40);
        let boxes = Boxes::new(&task.lineup);
        Self { task, boxes, pitch, turns, rasters: BTreeMap::new(), must_leave: task.separable, tests: 0 }
    }

    /// What stands already.
    pub(crate) fn stack(&self, standing: &[Piece]) -> Stack {
        let task = self.task;
        let mut stack = Stack {
            pieces: Vec::with_capacity(standing.len()),
            occupancy: Occupancy::new(task.room, task.reach_mm, self.pitch, self.lift()),
            skyline: self.boxes.skyline(&[]),
            near: Near::new(task.room),
            floors: BTreeMap::new(),
            filled: Filled::new(task.lineup.cap),
        };
        for zone in &task.zones {
            let half_mm = 0.5 * task.reach_mm;
            // Parts are grown by half a clearance that a zone does not ask for; of a thin one the middle stays.
            let thin_mm = 0.3 * self.pitch - 0.5 * zone.bounds.size().min_element();
            let reach_mm = (GROW * self.pitch - half_mm).max(thin_mm);
            let shape = &task.kind(zone.item).shape;
            stack.occupancy.fill_solid(shape, &zone.pose, &zone.bounds, reach_mm, half_mm);
        }
        for piece in standing {
            self.fill(&mut stack.occupancy, piece);
            stack.push(task, piece.clone());
        }
        stack
    }

    /// Voxels that every part is drawn higher by, so that clearances hold when it is raised.
    fn lift(&self) -> usize {
        (self.task.z_extra_mm / self.pitch).ceil() as usize
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
        let built = self.build_once(recipe, order, standing, worst_mm, &mut enough);
        self.must_leave = self.task.separable;
        if !self.task.separable {
            return built;
        }
        let (kept, dropped) = parted(self.task, built?);
        if dropped.is_empty() {
            return Some(kept);
        }
        let again: BTreeSet<(usize, u32)> = dropped.iter().map(|p| (p.item, p.copy)).collect();
        let again: Vec<(usize, u32)> = order.iter().copied().filter(|copy| again.contains(copy)).collect();
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
        let mut stack = self.stack(standing);
        for &copy in order {
            if enough(self.tests) {
                return None;
            }
            let placed = self.put(recipe, copy, &mut stack);
            if placed && stack.pieces.last().is_some_and(|piece| piece.bounds.max.z >= worst_mm) {
                return None;
            }
        }
        Some(stack.pieces)
    }

    /// Finds a place for one more copy. Returns whether there is one.
    pub(crate) fn put(&mut self, recipe: &Recipe, copy: (usize, u32), stack: &mut Stack) -> bool {
        if let Some(piece) = self.place(recipe, copy, stack) {
            stack.push(self.task, piece);
            return true;
        }
        let Some(piece) = self.boxes.on_top(copy, &mut stack.skyline, &stack.filled) else { return false };
        self.fill(&mut stack.occupancy, &piece);
        stack.push(self.task, piece);
        true
    }

    fn fill(&self, occupancy: &mut Occupancy, piece: &Piece) {
        let half_mm = 0.5 * self.task.reach_mm;
        let shape = &self.task.kind(piece.item).shape;
        occupancy.fill_solid(shape, &piece.pose, &piece.bounds, half_mm + GROW * self.pitch, half_mm);
    }

    /// The best place on the lattice that the triangles confirm.
    fn place(&mut self, recipe: &Recipe, copy: (usize, u32), stack: &mut Stack) -> Option<Piece> {
        let (task, pitch, lift) = (self.task, self.pitch, self.lift());
        let rasters = self.rasters.entry(copy.0).or_insert_with(|| {
            let turns = turns_of(task.lineup.candidate(copy.0), task.room, self.turns);
            let shape = &task.kind(copy.0).shape;
            turns.into_iter().map(|turn| Raster::new(shape, turn, task.reach_mm, pitch, GROW).lifted(lift)).collect()
        });
        let mut floors = stack.floors.remove(&copy.0).unwrap_or_else(|| Floors::new(&stack.occupancy, rasters));
        let mut found = None;
        let (mut failed, mut held, mut raises) = (0, 0, 0);
        while failed < TRIES && held < MOST_HELD && raises < RAISES {
            let lowest = floors.lowest_score(recipe, &stack.occupancy, rasters, &mut self.tests);
            let Some((at, node)) = lowest else { break };
            let raster = &rasters[at];
            let piece = task.piece(copy, raster.turn, stack.occupancy.place(raster, node));
            if !(task.is_inside(&piece, task.room.z) && stack.is_clear(task, &piece)) {
                floors.forbid(at, node);
                failed += 1;
            } else if let Some(layers) = stack.layers_missing(task, &piece) {
                // Its layers are full wherever it stands on the base: all positions of this rotation wait for higher ones.
                floors.raise(at, node[2], (layers / pitch).ceil().max(1.0) as usize);
                raises += 1;
            // When each can leave those before it, all can leave in the opposite order.
            } else if self.must_leave && !can_leave(task, &piece, &stack.pieces) {
                let reach = 0.25 * task.kind(copy.0).shape.radius_mm / pitch;
                floors.forbid_around(node, reach.ceil() as usize);
                held += 1;
            } else {
                stack.occupancy.fill(raster, node);
                found = Some(piece);
                break;
            }
        }
        stack.remember(copy.0, floors);
        found
    }
}

impl Stack {
    /// By how much a piece must be raised so that no layer is filled beyond the cap, mm; `None` when it need not.
    fn layers_missing(&self, task: &Task, piece: &Piece) -> Option<f64> {
        if !self.filled.is_capped() {
            return None;
        }
        match self.filled.raise(&slice(task, piece)) {
            Some(0) => None,
            Some(layers) => Some(layers as f64 * task.lineup.cap.layer_mm),
            None => Some(task.room.z),
        }
    }

    fn push(&mut self, task: &Task, piece: Piece) {
        if self.filled.is_capped() {
            self.filled.add(&slice(task, &piece));
        }
        self.near.add(self.pieces.len(), &piece.bounds);
        self.skyline.add(&lifted(&piece.bounds, task.z_extra_mm));
        self.pieces.push(piece);
    }

    /// Whether a piece keeps its clearance to all others. Exact.
    fn is_clear(&self, task: &Task, piece: &Piece) -> bool {
        let near = self.near.around(&piece.bounds, task.near_mm());
        near.into_iter().map(|other| &self.pieces[other]).chain(&task.zones).all(|other| task.is_clear(piece, other))
    }

    fn remember(&mut self, item: usize, floors: Floors) {
        if self.floors.values().map(Floors::bytes).sum::<usize>() + floors.bytes() > MOST_FLOORS {
            self.floors.clear();
        }
        self.floors.insert(item, floors);
    }
}
