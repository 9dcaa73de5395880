//! The layout while it is changed: overlaps are allowed and weighed, walls, floor and lid are not passed.

use glam::{DQuat, DVec3, Vec3};

use super::{
    OrientationRule,
    fit::shift_inside,
    locks::Locks,
    near::Near,
    notes::{Notes, Wanted},
    piece::{CLEARANCE_SPARE_MM, Piece, Task, clearance_of_pair, lifted},
    push::{Guide, Push},
    touch,
};

/// What guides keep from the walls, mm: their bounds are of single precision.
const GUIDE_SPARE_MM: f32 = 2e-4;
/// Parts are pushed so much further apart than they must be, mm: a push that ends exactly at the bound never arrives.
const OVERSHOOT_MM: f32 = 0.03;

/// The same for exact contacts.
const TOUCH_OVERSHOOT_MM: f32 = 0.004;
/// With no more parts than this, looking at all of them is quicker than a grid.
const FEW: usize = 100;
/// What is aimed at beyond the clearance, mm.
const WANTED_SPARE_MM: f32 = 2e-3;
/// Contacts of a failing pair are collected as far as this beyond its clearance, mm.
const TOUCH_LIMIT_MM: f64 = 0.1;

/// What the guides may be wrong by at most, mm: the greatest margin of a pair.
const MARGIN_MM: f32 = 1.5;

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
    /// Parts that must not move: promised ones and zones, which stand after all pieces.
    pub(crate) fixed: Vec<bool>,
    /// Parts that are pieces.
    pieces: usize,
    /// Raisings at which overlap is looked for, mm; 0 alone where clearances hold for no more than the parts as they stand.
    lifts: Vec<f32>,
    notes: Notes,
    /// How often each part has moved.
    moves: Vec<u32>,
    /// Who was locked into whom.
    pub(crate) locks: Locks,
    /// The best flowers of each part's last relocation.
    pub(crate) flowers: Vec<Vec<Vec<f64>>>,
    /// Where parts stand, once there are many.
    grid: Option<Near>,
    /// Height that must not be passed, mm.
    pub(crate) lid_mm: f64,
    /// Looks at one part among its neighbours.
    pub(crate) evaluations: u64,
}

impl<'t> Layout<'t> {
    /// The layout of pieces, under a lid.
    pub(crate) fn new(task: &'t Task, pieces: &[Piece], lid_mm: f64) -> Self {
        let guide = |p: &Piece| Guide::new(task.kind(p.item).shape.clone(), p.turn, p.place);
        let parts = || pieces.iter().chain(&task.zones);
        let guides: Vec<Guide> = parts().map(guide).collect();
        let grid = (guides.len() > FEW).then(|| {
            let mut grid = Near::new(task.room);
            guides.iter().enumerate().for_each(|(part, guide)| grid.add(part, &guide.bounds()));
            grid
        });
        Self {
            task,
            grid,
            fixed: parts().map(|p| task.is_fixed((p.item, p.copy))).collect(),
            pieces: pieces.len(),
            copies: parts().map(|p| (p.item, p.copy)).collect(),
            stands: parts().map(|p| Stand { turn: p.turn, place: p.place }).collect(),
            clearances: parts().map(|p| task.kind(p.item).clearance_mm as f32).collect(),
            lifts: task.lifts(),
            notes: Notes::new(guides.len()),
            moves: vec![0; guides.len()],
            flowers: vec![Vec::new(); guides.len()],
            guides,
            locks: Locks::new(),
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
        if self.fixed[part] {
            return;
        }
        let mut guide = self.guides[part].clone();
        let mut stand = self.clamp(&mut guide, stand);
        let known = self.stands[part];
        if known.place == stand.place && known.turn == stand.turn {
            return;
        }
        // The guides' bounds are those of some points; the triangles' are exact.
        let exact = guide.shape.tree.bounds_at(&guide.shape.pose(stand.turn, stand.place));
        let shift = shift_inside(&exact, self.task.room.with_z(self.lid_mm));
        stand.place += shift;
        guide.place = stand.place.as_vec3();
        (guide.min, guide.max) = ((exact.min + shift).as_vec3(), (exact.max + shift).as_vec3());
        self.moves[part] = self.moves[part].wrapping_add(1);
        self.stands[part] = stand;
        let before = std::mem::replace(&mut self.guides[part], guide);
        if let Some(grid) = &mut self.grid {
            grid.remove(part, &before.bounds());
            grid.add(part, &self.guides[part].bounds());
        }
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

    /// What holds between two parts.
    fn wanted(&self, one: usize, other: usize) -> Wanted<'_> {
        let (one_mm, other_mm) = (f64::from(self.clearances[one]), f64::from(self.clearances[other]));
        let clearance = clearance_of_pair(one_mm, other_mm) as f32 + WANTED_SPARE_MM;
        match self.notes.of(one, other) {
            Some(note) => {
                Wanted { reach: clearance + note.margin, clearance, weight: note.weight, touches: &note.touches }
            }
            None => Wanted { reach: clearance, clearance, weight: 1.0, touches: &[] },
        }
    }

    /// Overlap of a part, were it at `guide`, with another one; unweighted.
    fn overlap(&self, part: usize, guide: &Guide, other: usize, wanted: &Wanted<'_>, coarse: bool) -> f32 {
        let there = &self.guides[other];
        let once = |guide: &Guide| match coarse {
            true => guide.coarse_energy(there, wanted.reach),
            false => guide.energy(there, wanted.reach),
        };
        let energy: f32 = match self.lifts[..] {
            [_] => once(guide),
            _ => self.lifts.iter().map(|&lift| once(&guide.raised(lift))).sum(),
        };
        let energy = energy + self.locks.energy((part, guide), (other, there));
        if wanted.touches.is_empty() {
            return energy;
        }
        let (first, second) = if part < other { (guide, there) } else { (there, guide) };
        energy + touch::energy(wanted.touches, first, second, wanted.clearance)
    }

    /// How near bounds must come for a pair to be looked at.
    fn reach(&self) -> f32 {
        (self.task.reach_mm + self.task.z_extra_mm) as f32 + MARGIN_MM
    }

    /// Parts whose bounds come nearer to a guide than any pair may be, in rising order.
    fn near<'a>(&'a self, part: usize, guide: &'a Guide) -> impl Iterator<Item = usize> + use<'a, 't> {
        let reach = self.reach();
        let around = self.grid.as_ref().map(|grid| grid.around(&guide.bounds(), f64::from(reach)));
        let all = if around.is_some() { 0..0 } else { 0..self.len() };
        let candidates = around.unwrap_or_default().into_iter().chain(all);
        candidates.filter(move |&other| other != part && guide.is_near(&self.guides[other], reach))
    }

    /// Pairs whose bounds come nearer than any pair may be, each once, in rising order.
    fn near_pairs(&self) -> Vec<(usize, usize)> {
        let of = |one: usize| {
            self.near(one, &self.guides[one])
                .filter(move |&other| other > one && !self.are_fixed(one, other))
                .map(move |o| (one, o))
        };
        (0..self.len()).flat_map(of).collect()
    }

    /// Weighted overlap of a part, were it at `guide`; stops counting above `enough`.
    pub(crate) fn energy_at(&self, part: usize, guide: &Guide, coarse: bool, enough: f32) -> f32 {
        let mut energy = self.excess_energy(guide);
        for other in self.near(part, guide) {
            let wanted = self.wanted(part, other);
            energy += wanted.weight * self.overlap(part, guide, other, &wanted, coarse);
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
            let (wanted, there) = (self.wanted(part, other), &self.guides[other]);
            match self.lifts[..] {
                [_] => guide.push_from(there, wanted.reach + OVERSHOOT_MM, wanted.weight, &mut push),
                _ => self.lifts.iter().for_each(|&lift| {
                    guide.raised(lift).push_from(there, wanted.reach + OVERSHOOT_MM, wanted.weight, &mut push);
                }),
            }
            let pair = if part < other { (guide, there) } else { (there, guide) };
            let aim = (wanted.clearance + TOUCH_OVERSHOOT_MM, wanted.weight);
            touch::push(wanted.touches, pair, part < other, aim, &mut push);
            self.locks.push((part, guide), (other, there), wanted.weight, &mut push);
        }
        let rule = if self.task.organs.turning { self.rule(part) } else { OrientationRule::Fixed };
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

    /// Whether neither of two parts may move: then nothing can be wrong between them that could be helped.
    fn are_fixed(&self, one: usize, other: usize) -> bool {
        self.fixed[one] && self.fixed[other]
    }

    /// Overlap of two parts where they stand, unweighted; known as long as neither moves.
    fn pair_energy(&mut self, one: usize, other: usize) -> f32 {
        let now = (self.moves[one], self.moves[other]);
        if let Some((at, energy)) = self.notes.of(one, other).and_then(|note| note.seen)
            && at == now
        {
            return energy;
        }
        let energy = self.overlap(one, &self.guides[one], other, &self.wanted(one, other), false);
        self.notes.of_mut(one, other).seen = Some((now, energy));
        energy
    }

    /// Overlap of every part, unweighted pairs summed; pair weights grow where there is overlap and decay elsewhere.
    pub(crate) fn weigh(&mut self, energies: &mut Vec<f32>) -> f32 {
        energies.clear();
        energies.resize(self.len(), 0.0);
        let mut pairs: Vec<(usize, usize, f32)> = Vec::new();
        for (energy, guide) in energies.iter_mut().zip(&self.guides[..self.pieces]) {
            *energy += self.excess_energy(guide);
        }
        for (one, other) in self.near_pairs() {
            let energy = self.pair_energy(one, other);
            if energy > 0.0 {
                energies[one] += energy;
                energies[other] += energy;
                pairs.push((one, other, energy));
            }
        }
        self.evaluations += self.len() as u64 / 2 + 1;
        let worst = pairs.iter().fold(1e-12_f32, |most, p| most.max(p.2));
        self.notes.decay(0.95);
        for &(one, other, energy) in pairs.iter().filter(|_| self.task.organs.weights) {
            let note = self.notes.of_mut(one, other);
            // Twice for the worst pair, 1.2 times for the least (the decay above taken back).
            note.weight = (note.weight / 0.95 * (1.2 + 0.8 * (energy / worst).sqrt())).min(1e5);
        }
        energies.iter().sum()
    }

    /// Two parts that were locked into each other keep their hulls apart. Whether that is new.
    pub(crate) fn keep_hulls_apart(&mut self, one: usize, other: usize) -> bool {
        self.notes.of_mut(one, other).seen = None;
        self.locks.keep_apart(one, other)
    }

    /// Forgets weights, and a part of the margins.
    pub(crate) fn forget(&mut self) {
        self.notes.forget();
        self.locks.forget();
    }

    /// The pieces, when every one is exactly inside and clear of all others; otherwise margins grow where it was not.
    pub(crate) fn confirm(&mut self) -> Option<Vec<Piece>> {
        let task = self.task;
        let pieces: Vec<Piece> =
            (self.copies.iter().zip(&self.stands)).map(|(&copy, s)| task.piece(copy, s.turn, s.place)).collect();
        let inside = pieces[..self.pieces].iter().all(|piece| task.is_inside(piece, self.lid_mm + 1e-9));
        let clear = self.check_pairs(&pieces);
        (inside && clear).then(|| pieces[..self.pieces].to_vec())
    }

    /// Whether all pairs are clear on the triangles; where one is not, its contacts are kept, or its margin grows.
    fn check_pairs(&mut self, pieces: &[Piece]) -> bool {
        let task = self.task;
        let mut clear = true;
        for (one, other) in self.near_pairs() {
            let wanted = task.clearance_mm(pieces[one].item, pieces[other].item) + CLEARANCE_SPARE_MM;
            let near = lifted(&pieces[one].bounds, task.z_extra_mm);
            if near.distance(&lifted(&pieces[other].bounds, task.z_extra_mm)) >= wanted {
                continue;
            }
            let now = (self.moves[one], self.moves[other]);
            if self.notes.of(one, other).is_some_and(|note| note.clear_at == Some(now)) {
                continue;
            }
            self.evaluations += 1;
            let gap = task.gap_mm(&pieces[one], &pieces[other]);
            let deceived = gap >= wanted && self.pair_energy(one, other) > 0.0;
            let note = self.notes.of_mut(one, other);
            note.seen = None;
            if gap >= wanted {
                note.clear_at = Some(now);
                // The guides see an overlap that is none.
                note.margin = if deceived { (note.margin - 0.1).max(-MARGIN_MM) } else { note.margin };
                continue;
            }
            clear = false;
            if gap > 0.0 {
                touch::find(task, &pieces[one], &pieces[other], wanted + TOUCH_LIMIT_MM, &mut note.touches);
            } else {
                note.margin = (note.margin + 0.4).min(MARGIN_MM);
            }
        }
        clear
    }
}
