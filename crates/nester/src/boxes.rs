//! Boxes on boxes: the first layout of all, and what stands where nothing else found a place. It asks for a part's extents
//! only, so that it stands before any mesh is prepared.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DQuat, DVec3};
use solids::{Bounds, Pose};

use super::{
    first_turns::first_turns,
    fit::WALL_SPARE_MM,
    layers::{Filled, Slice},
    outline::{Candidate, Lineup},
    piece::{CLEARANCE_SPARE_MM, Piece, lifted},
    skyline::Skyline,
};

/// Cells of the base for few copies, and for many: many are small, and each asks all cells.
const CELLS: [f64; 2] = [20_000.0, 8_000.0];
/// From here on copies are many.
const MANY: usize = 200;
/// Ways of lying that are tried for an item.
const WAYS: usize = 6;

/// A way for an item to lie: a rotation, and the bounds that it gives around its center.
#[derive(Debug, Clone)]
struct Way {
    turn: DQuat,
    bounds: Bounds,
}

/// Stacks boxes; knows how every item can lie.
#[derive(Debug, Clone)]
pub(crate) struct Boxes<'a> {
    lineup: &'a Lineup,
    ways: BTreeMap<usize, Vec<Way>>,
}

impl<'a> Boxes<'a> {
    /// For the items of a line-up.
    pub(crate) fn new(lineup: &'a Lineup) -> Self {
        Self { lineup, ways: BTreeMap::new() }
    }

    /// A base with what stands on it.
    pub(crate) fn skyline(&self, standing: &[Piece]) -> Skyline {
        let mut skyline = Skyline::new(self.lineup.room, CELLS[usize::from(self.lineup.copies.len() > MANY)]);
        self.lineup.zones.iter().for_each(|zone| skyline.keep_out(&zone.bounds));
        standing.iter().for_each(|piece| skyline.add(&lifted(&piece.bounds, self.lineup.z_extra_mm)));
        skyline
    }

    /// What stands, and copies where boxes alone put them, in the given order; those that find no place are left out.
    pub(crate) fn stack(&mut self, standing: &[Piece], copies: &[(usize, u32)]) -> Vec<Piece> {
        let mut skyline = self.skyline(standing);
        let mut filled = Filled::new(self.lineup.cap);
        let mut full: BTreeSet<usize> = BTreeSet::new();
        let mut pieces = standing.to_vec();
        standing.iter().for_each(|piece| self.fill(&mut filled, piece));
        for &copy in copies {
            // What found no place finds none on higher boxes.
            if full.contains(&copy.0) {
                continue;
            }
            match self.on_top(copy, &mut skyline, &filled) {
                Some(piece) => {
                    self.fill(&mut filled, &piece);
                    pieces.push(piece);
                }
                None => drop(full.insert(copy.0)),
            }
        }
        pieces
    }

    /// Counts a piece where layers have a cap.
    fn fill(&self, filled: &mut Filled, piece: &Piece) {
        if filled.is_capped() {
            let mesh = &self.lineup.candidate(piece.item).mesh;
            filled.add(&Slice::of(mesh, &piece.pose, self.lineup.cap.layer_mm));
        }
    }

    /// Stands a copy on whatever boxes are below it, higher where its layers are full.
    pub(crate) fn on_top(&mut self, copy: (usize, u32), skyline: &mut Skyline, filled: &Filled) -> Option<Piece> {
        let lineup = self.lineup;
        let candidate = lineup.candidate(copy.0);
        let ways = self.ways.entry(copy.0).or_insert_with(|| ways_of(candidate, lineup.room));
        let mut best: Option<(f64, DVec3, &Way)> = None;
        for way in ways.iter() {
            let size = way.bounds.size();
            let Some(corner) = skyline.lowest(size, lineup.reach_mm + CLEARANCE_SPARE_MM) else { continue };
            let top = corner.z + size.z;
            if best.is_none_or(|(least, ..)| top < least - 1e-9) {
                best = Some((top, corner, way));
            }
        }
        let (_, corner, way) = best?;
        let place = corner - way.bounds.min;
        let bounds = Bounds { min: corner, max: way.bounds.max + place };
        let turn = way.turn;
        let pose = Pose::new(turn, place - turn * candidate.outline.obb.pose.translation);
        let mut piece = Piece { item: copy.0, copy: copy.1, turn, place, pose, bounds };
        if filled.is_capped() {
            // The room above it is free.
            piece = piece.moved(DVec3::Z * filled.lift_mm(&candidate.mesh, &pose)?);
            if piece.bounds.max.z > lineup.room.z - WALL_SPARE_MM {
                return None;
            }
        }
        skyline.add(&lifted(&piece.bounds, lineup.z_extra_mm));
        Some(piece)
    }
}

/// Rotations in which an item may lie with different extents, lowest first.
fn ways_of(candidate: &Candidate, room: DVec3) -> Vec<Way> {
    let center = candidate.outline.obb.pose.translation;
    let mut ways: Vec<Way> = Vec::new();
    for turn in turns_of(candidate, room, usize::MAX) {
        let rough = Bounds::around(candidate.outline.extremes.iter().map(|&p| turn * p)).size();
        let is_like = |way: &Way| (way.bounds.size() - rough).abs().max_element() < 0.05;
        if ways.iter().any(is_like) {
            continue;
        }
        let turn = turn.normalize();
        let bounds = candidate.mesh.bounds_at(&Pose::new(turn, -(turn * center)));
        ways.push(Way { turn, bounds });
        if ways.len() == WAYS {
            break;
        }
    }
    ways
}

/// Rotations to try for an item; never empty.
pub(crate) fn turns_of(candidate: &Candidate, room: DVec3, most: usize) -> Vec<DQuat> {
    let outline = &candidate.outline;
    let room = room - 2.0 * WALL_SPARE_MM;
    let mut turns = first_turns(&candidate.orientation, outline.obb.pose.rotation, &outline.extremes, room, most);
    if turns.is_empty() {
        turns.push(candidate.fitting);
    }
    turns
}
