//! The layout while it is changed: overlaps are allowed and weighed, walls, floor and lid are not passed.

use glam::{DQuat, DVec3, Vec3};

use super::{
    OrientationRule,
    fit::WALL_SPARE_MM,
    hulls,
    piece::{CLEARANCE_SPARE_MM, Piece, Task},
    push::{Guide, Push},
    separable::Leave,
};

/// What guides keep from the walls, mm: their bounds are of single precision.
const GUIDE_SPARE_MM: f32 = 2e-4;
/// Parts are pushed so much further apart than they must be, mm: a push that ends exactly at the bound never arrives.
const OVERSHOOT_MM: f32 = 0.03;

/// What the guides may be wrong by at most, mm: the greatest margin of a pair.
const MARGIN_MM: f32 = 1.5;

/// Lids for which two parts that were locked into each other keep their hulls apart.
const HULLS_APART_LIDS: u8 = 40;

/// What is remembered of a pair beside its being there.
#[derive(Debug, Clone, Copy)]
struct Note {
    other: u32,
    weight: f32,
    margin: f32,
    /// For so many lids more their convex hulls are kept apart: they were locked into each other.
    hulls_apart: u8,
}

/// Where one part stands; the turn is kept in full digits.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stand {
    pub(crate) turn: DQuat,
    pub(crate) place: DVec3,
}

/// The layout being changed.
#[derive(Debug, Clone)]
pub(crate) struct Layout<'t> {
    pub(crate) task: &'t Task,
    pub(crate) copies: Vec<(usize, u32)>,
    pub(crate) stands: Vec<Stand>,
    pub(crate) guides: Vec<Guide>,
    clearances: Vec<f32>,
    notes: Vec<Vec<Note>>,
    /// Whether any note keeps hulls apart.
    any_hulls: bool,
    /// How the last layout that was looked at came apart.
    pub(crate) leaves: Vec<Leave>,
    /// Height that must not be passed, mm.
    pub(crate) lid_mm: f64,
    /// Looks at one part among its neighbours.
    pub(crate) evaluations: u64,
}

impl<'t> Layout<'t> {
    /// The layout of pieces, under a lid.
    pub(crate) fn new(task: &'t Task, pieces: &[Piece], lid_mm: f64) -> Self {
        let guide = |p: &Piece| Guide::new(task.kind(p.item).shape.clone(), p.turn, p.place);
        Self {
            task,
            copies: pieces.iter().map(|p| (p.item, p.copy)).collect(),
            stands: pieces.iter().map(|p| Stand { turn: p.turn, place: p.place }).collect(),
            guides: pieces.iter().map(guide).collect(),
            clearances: pieces.iter().map(|p| task.kind(p.item).clearance_mm as f32).collect(),
            notes: vec![Vec::new(); pieces.len()],
            any_hulls: false,
            leaves: Vec::new(),
            lid_mm,
            evaluations: 0,
        }
    }

    /// Number of parts.
    pub(crate) fn len(&self) -> usize {
        self.stands.len()
    }

    /// Takes over where all parts stand.
    pub(crate) fn load(&mut self, stands: &[Stand]) {
        for (part, stand) in stands.iter().enumerate() {
            self.set(part, *stand);
        }
    }

    /// The rule of a part.
    pub(crate) fn rule(&self, part: usize) -> OrientationRule {
        self.task.kind(self.copies[part].0).rule
    }

    /// Moves a part, and then inside the walls as far as it fits.
    pub(crate) fn set(&mut self, part: usize, stand: Stand) {
        let mut guide = self.guides[part].clone();
        self.stands[part] = self.clamp(&mut guide, stand);
        self.guides[part] = guide;
    }

    /// Sets a guide to a stand, moved inside the walls; standing out at the far end where it is too long.
    pub(crate) fn clamp(&self, guide: &mut Guide, stand: Stand) -> Stand {
        guide.set(stand.turn, stand.place);
        let room = self.task.room.with_z(self.lid_mm).as_vec3() - GUIDE_SPARE_MM;
        // The guides know bounds to about a micron of single precision; the exact bounds are checked in the end.
        let shift = (room - guide.max).min(Vec3::ZERO);
        let shift = shift + (GUIDE_SPARE_MM - (guide.min + shift)).max(Vec3::ZERO);
        if shift == Vec3::ZERO {
            return stand;
        }
        let stand = Stand { turn: stand.turn, place: stand.place + shift.as_dvec3() };
        guide.place += shift;
        guide.min += shift;
        guide.max += shift;
        stand
    }

    /// By how much a clamped guide stands out of the room, weighed like overlap.
    pub(crate) fn excess_energy(&self, guide: &Guide) -> f32 {
        let room = self.task.room.with_z(self.lid_mm).as_vec3();
        let excess = (guide.max - room).max(Vec3::ZERO);
        let radius = guide.shape.radius_mm as f32;
        if excess.max_element() > 5e-4 { excess.length() * radius * radius } else { 0.0 }
    }

    fn note(&self, one: usize, other: usize) -> (f32, f32) {
        let (first, second) = (one.min(other), one.max(other) as u32);
        match self.notes[first].binary_search_by_key(&second, |n| n.other) {
            Ok(at) => (self.notes[first][at].weight, self.notes[first][at].margin),
            Err(_) => (1.0, 0.0),
        }
    }

    fn note_mut(&mut self, one: usize, other: usize) -> &mut Note {
        let (first, second) = (one.min(other), one.max(other) as u32);
        let notes = &mut self.notes[first];
        let at = match notes.binary_search_by_key(&second, |n| n.other) {
            Ok(at) => at,
            Err(at) => {
                notes.insert(at, Note { other: second, weight: 1.0, margin: 0.0, hulls_apart: 0 });
                at
            }
        };
        &mut notes[at]
    }

    /// Clearance of a pair, mm, and its weight.
    fn wanted(&self, one: usize, other: usize) -> (f32, f32) {
        let (weight, margin) = self.note(one, other);
        (self.clearances[one].max(self.clearances[other]) + margin + 5e-3, weight)
    }

    /// From now on and for many lids two parts keep their hulls apart. Whether that is new.
    pub(crate) fn keep_hulls_apart(&mut self, one: usize, other: usize) -> bool {
        self.any_hulls = true;
        let note = self.note_mut(one, other);
        std::mem::replace(&mut note.hulls_apart, HULLS_APART_LIDS) == 0
    }

    /// How the hulls of a part, were it at `guide`, and of another overlap, where they must not.
    fn hull_overlap(&self, part: usize, guide: &Guide, other: usize) -> Option<hulls::Overlap> {
        let (first, second) = (part.min(other), part.max(other) as u32);
        let notes = if self.any_hulls { &self.notes[first][..] } else { &[] };
        let at = notes.binary_search_by_key(&second, |n| n.other).ok()?;
        if notes[at].hulls_apart == 0 {
            return None;
        }
        hulls::overlap(guide, &self.guides[other])
    }

    /// The overlap of two hulls that must not, weighed like overlap of the parts; 0 for all others.
    fn hull_energy(&self, part: usize, guide: &Guide, other: usize) -> f32 {
        self.hull_overlap(part, guide, other).map_or(0.0, |hulls| hulls.depth * hulls.area)
    }

    /// Parts whose bounds come nearer to a guide than any pair may be.
    fn near<'a>(&'a self, part: usize, guide: &'a Guide) -> impl Iterator<Item = usize> + 'a {
        let reach = self.task.reach_mm as f32 + MARGIN_MM;
        (0..self.len()).filter(move |&other| other != part && guide.is_near(&self.guides[other], reach))
    }

    /// Weighted overlap of a part, were it at `guide`; stops counting above `enough`.
    pub(crate) fn energy_at(&self, part: usize, guide: &Guide, coarse: bool, enough: f32) -> f32 {
        let mut energy = self.excess_energy(guide);
        for other in self.near(part, guide) {
            let (reach, weight) = self.wanted(part, other);
            let there = &self.guides[other];
            energy += weight * if coarse { guide.coarse_energy(there, reach) } else { guide.energy(there, reach) };
            energy += weight * self.hull_energy(part, guide, other);
            if energy >= enough {
                break;
            }
        }
        energy
    }

    /// One Gauss-Newton step of a part out of all its overlaps. Returns the weighted overlap before the step.
    pub(crate) fn step(&mut self, part: usize) -> f32 {
        self.evaluations += 1;
        let guide = &self.guides[part];
        let mut push = Push::new(0.7 * guide.shape.radius_mm as f32);
        for other in self.near(part, guide) {
            let (reach, weight) = self.wanted(part, other);
            guide.push_from(&self.guides[other], reach + OVERSHOOT_MM, weight, &mut push);
            if let Some(hulls) = self.hull_overlap(part, guide, other) {
                push.add(Vec3::ZERO, hulls.way, hulls.depth + OVERSHOOT_MM, weight * hulls.area);
            }
        }
        let rule = self.rule(part);
        let energy = push.energy + self.excess_energy(guide);
        if energy <= 0.0 {
            return 0.0;
        }
        let (mut step, mut spin) = push.motion(rule);
        if self.hold_walls(part, step, spin, &mut push) {
            (step, spin) = push.motion(rule);
        }
        let stand = self.stands[part];
        let turn = match rule {
            OrientationRule::Free => (DQuat::from_scaled_axis(spin.as_dvec3()) * stand.turn).normalize(),
            OrientationRule::Upright => (DQuat::from_rotation_z(f64::from(spin.z)) * stand.turn).normalize(),
            OrientationRule::Axis | OrientationRule::Fixed => stand.turn,
        };
        self.set(part, Stand { turn, place: stand.place + step.as_dvec3() });
        energy
    }

    /// Adds contacts for the extreme points that a motion would carry through a wall.
    fn hold_walls(&self, part: usize, step: Vec3, spin: Vec3, push: &mut Push) -> bool {
        let guide = &self.guides[part];
        let room = self.task.room.with_z(self.lid_mm).as_vec3();
        let weight = 0.02 * push.energy.max(1.0) + 0.2 * guide.shape.radius_mm as f32;
        let mut held = false;
        for &extreme in &guide.shape.extremes_f32 {
            let arm = guide.turn * extreme;
            let here = guide.place + arm;
            let there = here + step + spin.cross(arm);
            for axis in 0..3 {
                let unit = Vec3::AXES[axis];
                if there[axis] < -1e-3 {
                    push.add(arm, unit, (-here[axis]).min(1.0), weight);
                    held = true;
                } else if there[axis] > room[axis] + 1e-3 {
                    push.add(arm, -unit, (here[axis] - room[axis]).min(1.0), weight);
                    held = true;
                }
            }
        }
        held
    }

    /// Overlap of every part, unweighted pairs summed; pair weights grow where there is overlap and decay elsewhere.
    pub(crate) fn weigh(&mut self, energies: &mut Vec<f32>) -> f32 {
        energies.clear();
        energies.resize(self.len(), 0.0);
        let mut pairs: Vec<(usize, usize, f32)> = Vec::new();
        let reach = self.task.reach_mm as f32 + MARGIN_MM;
        for one in 0..self.len() {
            energies[one] += self.excess_energy(&self.guides[one]);
            for other in one + 1..self.len() {
                if self.guides[one].is_near(&self.guides[other], reach) {
                    let energy = self.guides[one].energy(&self.guides[other], self.wanted(one, other).0)
                        + self.hull_energy(one, &self.guides[one], other);
                    if energy > 0.0 {
                        energies[one] += energy;
                        energies[other] += energy;
                        pairs.push((one, other, energy));
                    }
                }
            }
        }
        self.evaluations += self.len() as u64 / 2 + 1;
        let worst = pairs.iter().fold(1e-12_f32, |most, p| most.max(p.2));
        for notes in &mut self.notes {
            notes.iter_mut().for_each(|n| n.weight = (n.weight * 0.95).max(1.0));
        }
        for &(one, other, energy) in &pairs {
            let note = self.note_mut(one, other);
            // Twice for the worst pair, 1.2 times for the least (the decay above taken back).
            note.weight = (note.weight / 0.95 * (1.2 + 0.8 * (energy / worst).sqrt())).min(1e5);
        }
        energies.iter().sum()
    }

    /// Forgets weights, a part of the margins, and after many lids who was locked.
    pub(crate) fn forget(&mut self) {
        for notes in &mut self.notes {
            for n in notes.iter_mut() {
                (n.weight, n.margin, n.hulls_apart) = (1.0, 0.7 * n.margin, n.hulls_apart.saturating_sub(1));
            }
            notes.retain(|n| n.margin > 0.01 || n.hulls_apart > 0);
        }
        self.any_hulls = self.notes.iter().flatten().any(|n| n.hulls_apart > 0);
    }

    /// The pieces, when every one is exactly inside and clear of all others; otherwise margins grow where it was not.
    pub(crate) fn confirm(&mut self) -> Option<Vec<Piece>> {
        let task = self.task;
        let mut pieces: Vec<Piece> =
            (self.copies.iter().zip(&self.stands)).map(|(&copy, s)| task.piece(copy, s.turn, s.place)).collect();
        for (piece, stand) in pieces.iter_mut().zip(&mut self.stands) {
            nudge_inside(task, piece, stand, self.lid_mm);
        }
        let mut good = pieces.iter().all(|piece| task.is_inside(piece, self.lid_mm + 1e-9));
        for one in 0..pieces.len() {
            for other in one + 1..pieces.len() {
                let wanted = task.clearance_mm(pieces[one].item, pieces[other].item) + CLEARANCE_SPARE_MM;
                if pieces[one].bounds.distance(&pieces[other].bounds) >= wanted {
                    continue;
                }
                let gap = task.gap_mm(&pieces[one], &pieces[other]);
                if gap < wanted {
                    good = false;
                    let missing = ((wanted - gap) as f32).min(MARGIN_MM);
                    let note = self.note_mut(one, other);
                    note.margin = (note.margin + missing + 0.01).min(MARGIN_MM);
                }
            }
        }
        good.then_some(pieces)
    }
}

/// Moves a piece inside the walls by its exact bounds where the guides' bounds were a little off.
fn nudge_inside(task: &Task, piece: &mut Piece, stand: &mut Stand, lid_mm: f64) {
    if task.is_inside(piece, lid_mm) {
        return;
    }
    let room = task.room.with_z(lid_mm) - WALL_SPARE_MM;
    let shift = (room - piece.bounds.max).min(DVec3::ZERO);
    let shift = shift + (WALL_SPARE_MM - (piece.bounds.min + shift)).max(DVec3::ZERO);
    if shift.abs().max_element() < 0.3 {
        stand.place += shift;
        *piece = task.piece((piece.item, piece.copy), stand.turn, stand.place);
    }
}
