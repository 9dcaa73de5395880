//! The layout while it is changed: overlaps are allowed and weighed, walls, floor and lid are not passed.

use glam::{DQuat, DVec3, Vec3};

use super::{
    OrientationRule,
    fit::WALL_SPARE_MM,
    piece::{CLEARANCE_SPARE_MM, Piece, Task, lifted},
    push::{Guide, Push},
};

/// What guides keep from the walls, mm: their bounds are of single precision.
const GUIDE_SPARE_MM: f32 = 2e-4;
/// Parts are pushed so much further apart than they must be, mm: a push that ends exactly at the bound never arrives.
const OVERSHOOT_MM: f32 = 0.03;

/// What the guides may be wrong by at most, mm: the greatest margin of a pair.
const MARGIN_MM: f32 = 1.5;

/// What is remembered of a pair beside its being there.
#[derive(Debug, Clone, Copy)]
struct Note {
    other: u32,
    weight: f32,
    margin: f32,
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
    /// Raisings at which overlap is looked for, mm; 0 alone where clearances hold for no more than the parts as they stand.
    lifts: Vec<f32>,
    notes: Vec<Vec<Note>>,
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
            lifts: lifts(task),
            notes: vec![Vec::new(); pieces.len()],
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
        self.task.kind(self.copies[part].0).orientation.rule
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
                notes.insert(at, Note { other: second, weight: 1.0, margin: 0.0 });
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

    /// How near bounds must come for a pair to be looked at.
    fn reach(&self) -> f32 {
        (self.task.reach_mm + self.task.z_extra_mm) as f32 + MARGIN_MM
    }

    /// Overlap of a guide with a part, summed over the ways that either may be raised.
    fn pair_energy(&self, guide: &Guide, other: usize, reach: f32, coarse: bool) -> f32 {
        let there = &self.guides[other];
        let one = |guide: &Guide| match coarse {
            true => guide.coarse_energy(there, reach),
            false => guide.energy(there, reach),
        };
        self.lifts.iter().map(|&lift| if lift == 0.0 { one(guide) } else { one(&guide.raised(lift)) }).sum()
    }

    /// Parts whose bounds come nearer to a guide than any pair may be.
    fn near<'a>(&'a self, part: usize, guide: &'a Guide) -> impl Iterator<Item = usize> + 'a {
        let reach = self.reach();
        (0..self.len()).filter(move |&other| other != part && guide.is_near(&self.guides[other], reach))
    }

    /// Weighted overlap of a part, were it at `guide`; stops counting above `enough`.
    pub(crate) fn energy_at(&self, part: usize, guide: &Guide, coarse: bool, enough: f32) -> f32 {
        let mut energy = self.excess_energy(guide);
        for other in self.near(part, guide) {
            let (reach, weight) = self.wanted(part, other);
            energy += weight * self.pair_energy(guide, other, reach, coarse);
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
            for &lift in &self.lifts {
                let there = &self.guides[other];
                match lift == 0.0 {
                    true => guide.push_from(there, reach + OVERSHOOT_MM, weight, &mut push),
                    false => guide.raised(lift).push_from(there, reach + OVERSHOOT_MM, weight, &mut push),
                }
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
            OrientationRule::Free => {
                let spun = (DQuat::from_scaled_axis(spin.as_dvec3()) * stand.turn).normalize();
                self.task.kind(self.copies[part].0).orientation.nearest(spun).unwrap_or(stand.turn)
            }
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
        let reach = self.reach();
        for one in 0..self.len() {
            energies[one] += self.excess_energy(&self.guides[one]);
            for other in one + 1..self.len() {
                if self.guides[one].is_near(&self.guides[other], reach) {
                    let energy = self.pair_energy(&self.guides[one], other, self.wanted(one, other).0, false);
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

    /// Forgets weights, and half of the margins.
    pub(crate) fn forget(&mut self) {
        for notes in &mut self.notes {
            notes.iter_mut().for_each(|n| (n.weight, n.margin) = (1.0, 0.7 * n.margin));
            notes.retain(|n| n.margin > 0.01);
        }
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
                let near = lifted(&pieces[one].bounds, task.z_extra_mm);
                if near.distance(&lifted(&pieces[other].bounds, task.z_extra_mm)) >= wanted {
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

/// Where guides look for overlap: what may be raised by more than a clearance is looked at in between, too.
fn lifts(task: &Task) -> Vec<f32> {
    let extra = task.z_extra_mm;
    if extra <= 0.0 {
        return vec![0.0];
    }
    let steps = (extra / task.reach_mm.max(1.0)).ceil().min(4.0) as i32;
    (-steps..=steps).map(|step| (extra * f64::from(step) / f64::from(steps)) as f32).collect()
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
