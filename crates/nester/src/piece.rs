//! What is nested and how a layout is judged while it is built: exactly, on the triangles.

use std::{collections::BTreeSet, ops::Range, sync::Arc};

use glam::{DQuat, DVec3};
use solids::{Bounds, Mesh, Pose};

use super::{
    Instance, Organs, Orientation, OrientationRule, Placement, Solution,
    fit::WALL_SPARE_MM,
    layers::{Filled, Slice},
    outline::{Candidate, Lineup},
    reserved::Zone,
    shape::{Detail, Shape},
    workshop::Workshop,
};

/// What two placements keep beyond their clearance, mm, so that rounding in a written file never breaks it.
pub(crate) const CLEARANCE_SPARE_MM: f64 = 1e-4;

/// An item that fits the volume, prepared.
#[derive(Debug, Clone)]
pub(crate) struct Kind {
    pub(crate) shape: Arc<Shape>,
    pub(crate) orientation: Orientation,
    /// Clearance asked for it, mm; between two parts the greater holds.
    pub(crate) clearance_mm: f64,
}

/// The instance, prepared. `kinds` has one entry per item; `None` for those that fit in no allowed orientation.
#[derive(Debug, Clone)]
pub(crate) struct Task {
    /// The same items from outside.
    pub(crate) lineup: Arc<Lineup>,
    pub(crate) kinds: Vec<Option<Kind>>,
    /// All copies that fit alone, in order of precedence.
    pub(crate) copies: Vec<(usize, u32)>,
    pub(crate) room: DVec3,
    /// The greatest clearance of any item, mm.
    pub(crate) reach_mm: f64,
    /// Where nothing may stand: pieces of kinds that come after those of the items.
    pub(crate) zones: Vec<Piece>,
    /// Copies that never move.
    pub(crate) pins: BTreeSet<(usize, u32)>,
    /// Clearances also hold when either part is raised by up to this, mm.
    pub(crate) z_extra_mm: f64,
    /// Which organs of the search take part.
    pub(crate) organs: Organs,
    /// Whether a layout counts only when no part is locked into others.
    pub(crate) separable: bool,
}

impl Task {
    /// Prepares every distinct mesh of a line-up; `None` when the workshop's time is over before. Locked parts are let be.
    pub(crate) fn new(
        lineup: Arc<Lineup>,
        pins: BTreeSet<(usize, u32)>,
        workshop: &Workshop<'_>,
        organs: Organs,
        nodes: usize,
        points: usize,
    ) -> Option<Self> {
        let detail = Detail { nodes, points, reach_mm: lineup.reach_mm + 0.5 };
        let zones = || lineup.zones.iter().map(|zone| &zone.mesh);
        let items = lineup.candidates.iter().flatten().map(|c| &c.mesh);
        let meshes: Vec<Arc<Mesh>> = items.chain(zones()).cloned().collect();
        let mut shapes = workshop.shapes(&meshes, detail)?.into_iter();
        let kind = |candidate: &Option<Candidate>| {
            let Candidate { orientation, clearance_mm, .. } = candidate.as_ref()?;
            Some(Kind { shape: shapes.next()?, orientation: orientation.clone(), clearance_mm: *clearance_mm })
        };
        let mut kinds: Vec<Option<Kind>> = lineup.candidates.iter().map(kind).collect();
        let zone =
            |shape| Some(Kind { shape, orientation: OrientationRule::Fixed.into(), clearance_mm: ZONE_CLEARANCE });
        kinds.extend(shapes.map(zone));
        let (copies, room) = (lineup.copies.clone(), lineup.room);
        let (reach_mm, z_extra_mm) = (lineup.reach_mm, lineup.z_extra_mm);
        let mut task = Self {
            kinds,
            copies,
            room,
            reach_mm,
            z_extra_mm,
            zones: Vec::new(),
            pins,
            organs,
            separable: false,
            lineup,
        };
        let place = |zone: &Zone| zone.bounds.center();
        let first = task.lineup.candidates.len();
        let zones = task.lineup.zones.iter().enumerate();
        task.zones = zones.map(|(at, zone)| task.piece((first + at, 0), DQuat::IDENTITY, place(zone))).collect();
        Some(task)
    }

    /// Prepares some of the items at another detail; they stay as they are when the workshop's time is over before.
    pub(crate) fn refine(&mut self, items: Range<usize>, workshop: &Workshop<'_>, nodes: usize, points: usize) {
        let detail = Detail { nodes, points, reach_mm: self.reach_mm + 0.5 };
        let mut kinds: Vec<&mut Kind> = self.kinds[items].iter_mut().flatten().collect();
        let meshes: Vec<Arc<Mesh>> = kinds.iter().map(|kind| kind.shape.tree.mesh().clone()).collect();
        let Some(shapes) = workshop.shapes(&meshes, detail) else { return };
        kinds.iter_mut().zip(shapes).for_each(|(kind, shape)| kind.shape = shape);
    }

    /// The prepared item of a copy that is being nested.
    pub(crate) fn kind(&self, item: usize) -> &Kind {
        self.kinds[item].as_ref().expect("only items that fit are nested")
    }

    /// Clearance between two items, mm.
    pub(crate) fn clearance_mm(&self, item1: usize, item2: usize) -> f64 {
        clearance_of_pair(self.kind(item1).clearance_mm, self.kind(item2).clearance_mm)
    }

    /// A copy at a rotation and a place of its center.
    pub(crate) fn piece(&self, (item, copy): (usize, u32), turn: DQuat, place: DVec3) -> Piece {
        let shape = &self.kind(item).shape;
        let pose = shape.pose(turn, place);
        Piece { item, copy, turn, place, pose, bounds: shape.tree.bounds_at(&pose) }
    }

    /// Whether a copy may not be moved: it is promised, or it is a zone.
    pub(crate) fn is_fixed(&self, copy: (usize, u32)) -> bool {
        copy.0 >= self.lineup.candidates.len() || self.pins.contains(&copy)
    }

    /// Whether pieces fill no layer beyond the cap.
    pub(crate) fn keeps_cap(&self, pieces: &[Piece]) -> bool {
        let mut filled = Filled::new(self.lineup.cap);
        !filled.is_capped()
            || pieces.iter().all(|piece| {
                let slice = slice(self, piece);
                let takes = filled.takes(&slice);
                filled.add(&slice);
                takes
            })
    }

    /// Bounds further apart than this are clear, mm.
    pub(crate) fn near_mm(&self) -> f64 {
        self.reach_mm + self.z_extra_mm + 2.0 * CLEARANCE_SPARE_MM
    }

    /// Raisings at which guides look for overlap, mm: what may be raised by more than a clearance is looked at in between,
    /// too.
    pub(crate) fn lifts(&self) -> Vec<f32> {
        if self.z_extra_mm <= 0.0 {
            return vec![0.0];
        }
        let steps = (self.z_extra_mm / self.reach_mm.max(1.0)).ceil().min(4.0) as i32;
        (-steps..=steps).map(|step| (self.z_extra_mm * f64::from(step) / f64::from(steps)) as f32).collect()
    }

    /// Whether a piece stands inside the walls.
    pub(crate) fn is_inside(&self, piece: &Piece, lid_mm: f64) -> bool {
        let room = Bounds { min: DVec3::ZERO, max: self.room.with_z(lid_mm.min(self.room.z)) };
        room.holds(&piece.bounds, WALL_SPARE_MM - 1e-7)
    }

    /// Whether two pieces keep their clearance and none is inside the other. Exact.
    pub(crate) fn is_clear(&self, one: &Piece, other: &Piece) -> bool {
        self.gap_mm(one, other) >= self.clearance_mm(one.item, other.item) + CLEARANCE_SPARE_MM
    }

    /// The same for pieces that were found clear before: rounding on the way through a file or a ledger moves nobody.
    pub(crate) fn is_still_clear(&self, one: &Piece, other: &Piece) -> bool {
        self.gap_mm(one, other) >= self.clearance_mm(one.item, other.item) + 0.5 * CLEARANCE_SPARE_MM
    }

    /// Distance between two pieces while either is raised as far as it may be, exact up to a little more than their clearance; negative when one is inside the other.
    pub(crate) fn gap_mm(&self, one: &Piece, other: &Piece) -> f64 {
        let cap = self.clearance_mm(one.item, other.item) + 2.0 * CLEARANCE_SPARE_MM;
        // Nothing is raised against a zone.
        let zones = self.lineup.candidates.len();
        let extra_mm = if one.item.max(other.item) >= zones { 0.0 } else { self.z_extra_mm };
        if lifted(&one.bounds, extra_mm).distance(&lifted(&other.bounds, extra_mm)) >= cap {
            return cap;
        }
        let (tree1, tree2) = (&self.kind(one.item).shape.tree, &self.kind(other.item).shape.tree);
        let pose12 = one.pose.seen(&other.pose);
        let gap = match extra_mm > 0.0 {
            true => tree1.distance_sliding_mm(tree2, &pose12, one.pose.inverse().direction(DVec3::Z * extra_mm), cap),
            false => tree1.distance_capped_mm(tree2, &pose12, cap),
        };
        if gap > 0.0 && one.bounds.holds(&other.bounds, 0.0) && tree1.holds_part(tree2, &pose12) {
            return -1.0;
        }
        let pose21 = pose12.inverse();
        if gap > 0.0 && other.bounds.holds(&one.bounds, 0.0) && tree2.holds_part(tree1, &pose21) {
            return -1.0;
        }
        gap
    }
}

/// Stands for the clearance of a zone: nothing keeps a distance from it.
const ZONE_CLEARANCE: f64 = -1.0;

/// Clearance between two of the given clearances, mm: the greater, and none to a zone.
pub(crate) fn clearance_of_pair(one_mm: f64, other_mm: f64) -> f64 {
    if one_mm.min(other_mm) < 0.0 { 0.0 } else { one_mm.max(other_mm) }
}

/// One placed copy.
#[derive(Debug, Clone)]
pub(crate) struct Piece {
    pub(crate) item: usize,
    pub(crate) copy: u32,
    pub(crate) turn: DQuat,
    /// Where the shape's center stands.
    pub(crate) place: DVec3,
    pub(crate) pose: Pose,
    /// Exact bounds.
    pub(crate) bounds: Bounds,
}

impl Piece {
    /// The same elsewhere.
    pub(crate) fn moved(mut self, shift: DVec3) -> Self {
        self.place += shift;
        self.pose.translation += shift;
        self.bounds = Bounds { min: self.bounds.min + shift, max: self.bounds.max + shift };
        self
    }
}

/// Bounds with what is kept free above them.
pub(crate) fn lifted(bounds: &Bounds, extra_mm: f64) -> Bounds {
    Bounds { min: bounds.min, max: bounds.max + DVec3::Z * extra_mm }
}

/// Top of the highest piece, mm.
pub(crate) fn height_mm(pieces: &[Piece]) -> f64 {
    pieces.iter().map(|p| p.bounds.max.z).fold(0.0, f64::max)
}

/// What a piece fills in each layer.
pub(crate) fn slice(task: &Task, piece: &Piece) -> Slice {
    Slice::of(task.kind(piece.item).shape.tree.mesh(), &piece.pose, task.lineup.cap.layer_mm)
}

/// The solution that pieces make.
pub(crate) fn solution(instance: &Instance, pieces: &[Piece], evaluations: u64) -> Solution {
    let mut placements: Vec<Placement> =
        pieces.iter().map(|p| Placement { item: p.item, copy: p.copy, pose: p.pose }).collect();
    placements.sort_by_key(|p| (p.item, p.copy));
    // What is promised stands where it was promised, to the last digit.
    for pin in instance.pinned() {
        if let Ok(at) = placements.binary_search_by_key(&(pin.item, pin.copy), |p| (p.item, p.copy)) {
            placements[at].pose = pin.pose;
        }
    }
    let placed = |copy: (usize, u32)| placements.binary_search_by_key(&copy, |p| (p.item, p.copy)).is_ok();
    let all = (instance.items().iter().enumerate()).flat_map(|(i, item)| (0..item.copies).map(move |c| (i, c)));
    let unplaced = all.filter(|&copy| !placed(copy)).collect();
    Solution { unplaced, height_mm: height_mm(pieces), evaluations, placements }
}
