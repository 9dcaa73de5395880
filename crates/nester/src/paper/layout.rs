//! One layout of the paper's method: parts in their sequence, each placed by a flower pollination of its own.

use glam::DVec3;
use solids::{Bounds, Pose};

use super::{clear::keeps_apart, shape::Shape, zones::Zones};
use crate::{
    Instance, PaperConfig, Placement, Stop,
    layers::{Filled, Slice},
    pollination::{Edge, Gene, Pollination, Setup},
};

/// How often a flower whose proposal interferes is drawn anew within one turn (step 4 of figure 9 goes back without end,
/// which in a full container would never return).
const REDRAWS: usize = 8;
/// Proposals between two looks at the budget.
const LOOK_EVERY: u64 = 16;
/// Numbers of a genome that stand for the position.
const POSITION: usize = 3;

/// Height of the layout with this part first, then its distance from the origin, mm.
type Fitness = (f64, f64);

/// A layout that is being built up.
pub(super) struct Layout<'a> {
    instance: &'a Instance,
    shapes: &'a [Shape],
    zones: &'a Zones,
    placed: Vec<Placed>,
    top_mm: f64,
    filled: Filled,
    /// The placed part that stood in the way last; it probably does again.
    obstacle: usize,
}

struct Placed {
    placement: Placement,
    bounds: Bounds,
}

/// What a candidate pose would give.
struct Candidate {
    pose: Pose,
    bounds: Bounds,
    fitness: Fitness,
}

/// How the budget is looked at while a part is being placed.
pub(super) struct Pace<'a> {
    /// The budget.
    pub stop: &'a dyn Stop,
    /// The share of it at which the part must have its place.
    pub until: f64,
}

impl<'a> Layout<'a> {
    /// An empty layout.
    pub fn new(instance: &'a Instance, shapes: &'a [Shape], zones: &'a Zones) -> Self {
        let filled = Filled::new(instance.layer_cap());
        Self { instance, shapes, zones, placed: Vec::new(), top_mm: 0.0, filled, obstacle: 0 }
    }

    /// Puts promised copies where they were promised.
    pub fn pin(&mut self, pinned: &[Placement]) {
        for &placement in pinned.iter().filter(|p| p.item < self.shapes.len()) {
            let bounds = self.shapes[placement.item].surface.bounds_at(&placement.pose);
            self.top_mm = self.top_mm.max(bounds.max.z);
            self.placed.push(Placed { placement, bounds });
        }
    }

    /// Placed copies in the sequence of their placing.
    pub fn placements(&self) -> Vec<Placement> {
        self.placed.iter().map(|p| p.placement).collect()
    }

    /// Puts the first part into the corner at the origin in its initial orientation, or a quarter turned. Returns whether it
    /// fits so.
    pub fn place_in_corner(&mut self, item: usize, copy: u32) -> bool {
        let fit = (0..2).find_map(|quarters| {
            let mut genome = vec![0.0; POSITION];
            genome.extend(self.shapes[item].initial_genes(quarters));
            self.candidate(item, &genome)
        });
        match fit {
            Some(candidate)
                if self.placed.is_empty()
                    && !self.is_in_a_zone(item, &candidate)
                    && self.filled.takes(&self.slice(item, &candidate)) =>
            {
                self.put(item, copy, &candidate);
                true
            }
            _ => false,
        }
    }

    /// Finds a place by flower pollination (section 2.3.1, steps 1 to 8). Returns whether there is one; counts proposals.
    pub fn place(
        &mut self,
        (item, copy): (usize, u32),
        config: &PaperConfig,
        pace: &Pace,
        seed: u64,
        evaluations: &mut u64,
    ) -> bool {
        let setup = Setup {
            population: config.population,
            switch_probability: config.switch_probability,
            scale: config.scale,
            levy_exponent: config.levy_exponent,
            even: false,
        };
        let place = Gene { lower: 0.0, upper: 1.0, edge: Edge::Clamp };
        let genes = [vec![place; POSITION], self.shapes[item].rotation_genes()].concat();
        let mut search = Pollination::new(setup, genes, seed).starting_at(self.starts(item, config.population));
        let mut found: Option<Candidate> = None;
        let turns = config.population.max(1) as u64 * (config.iterations as u64 + 1);
        let start = *evaluations;
        for turn in 0..turns {
            if turn.is_multiple_of(LOOK_EVERY)
                && *evaluations > start + 4
                && pace.stop.spent(*evaluations) >= pace.until
            {
                break;
            }
            if let Some(better) = self.turn(item, &mut search, evaluations) {
                found = Some(better);
            }
        }
        if let Some(candidate) = &found {
            self.put(item, copy, candidate);
        }
        found.is_some()
    }

    /// One flower's turn; the candidate when it is the best so far.
    fn turn(&mut self, item: usize, search: &mut Pollination<Fitness>, evaluations: &mut u64) -> Option<Candidate> {
        for _ in 0..=REDRAWS {
            *evaluations += 1;
            let candidate = self.candidate(item, search.ask());
            let Some(candidate) = candidate else { continue };
            // The objective costs far less than the interference test: a place that is no better than the flower's own would
            // not be taken anyway, so it ends the turn untested.
            if search.own().is_some_and(|own| candidate.fitness >= *own) {
                break;
            }
            if self.interferes(item, &candidate) {
                continue;
            }
            let is_best = search.best().is_none_or(|(_, best)| candidate.fitness < *best);
            let is_barred = || {
                self.is_nested(item, &candidate)
                    || self.is_near_when_raised(item, &candidate)
                    || self.filled.is_capped() && !self.filled.takes(&self.slice(item, &candidate))
            };
            if is_best && is_barred() {
                continue;
            }
            return search.tell(candidate.fitness).then_some(candidate);
        }
        search.skip();
        None
    }

    /// Where the first flowers start: on top of everything in the corner at the origin, on the floor there, then scattered
    /// over the container in the initial orientation; half of the flowers are left to start anywhere in any orientation.
    fn starts(&self, item: usize, population: usize) -> Vec<Vec<f64>> {
        // Steps of the golden ratio's three-dimensional kin scatter more evenly than random numbers.
        let kin = [0.819_172_513_396_164_4, 0.671_043_606_703_789_3, 0.549_700_477_901_970_3];
        let flowers = population.div_ceil(2).max(4);
        let place = |flower: usize| match flower {
            0 | 1 => [0.0, 0.0, 1.0],
            2 | 3 => [0.0; POSITION],
            _ => kin.map(|step| (0.5 + flower as f64 * step).fract()),
        };
        let quarters = |flower: usize| (flower % 4) as u32;
        (0..flowers)
            .map(|f| {
                let mut genome = place(f).to_vec();
                genome.extend(self.shapes[item].initial_genes(quarters(f)));
                genome
            })
            .collect()
    }

    /// What a genome stands for, or `None` when its orientation is too large for the container. Position genes are shares of
    /// the way that the part can go within the walls, in z up to just above the highest part.
    fn candidate(&self, item: usize, genome: &[f64]) -> Option<Candidate> {
        let shape = &self.shapes[item];
        let rotation = shape.rotation(&genome[POSITION..]);
        if !shape.obeys(rotation) {
            return None;
        }
        let bounds = shape.surface.bounds_at(&Pose { rotation, translation: DVec3::ZERO });
        let mut free = self.instance.volume().size_mm - bounds.size();
        // A part exactly as large as the container fits, whatever rounding says.
        if free.min_element() < -1e-9 {
            return None;
        }
        free = free.max(DVec3::ZERO);
        free.z = free.z.min(self.above_all_mm(item));
        let corner = DVec3::new(genome[0], genome[1], genome[2]) * free;
        let translation = corner - bounds.min;
        let bounds = Bounds { min: corner, max: bounds.max + translation };
        let fitness = (self.top_mm.max(bounds.max.z), bounds.max.length());
        Some(Candidate { pose: Pose { rotation, translation }, bounds, fitness })
    }

    /// The height at which nothing is in the way any more, mm. A hair above the clearance, so that rounding cannot spoil it.
    fn above_all_mm(&self, item: usize) -> f64 {
        let extra_mm = self.instance.clearance_z_extra_mm();
        let clear =
            |p: &Placed| p.bounds.max.z + self.instance.clearance_between_mm(item, p.placement.item) + extra_mm + 1e-6;
        self.placed.iter().map(clear).fold(self.zones.top_mm(), f64::max)
    }

    /// Whether the candidate comes too near to a placed part as far as its boxes can tell (figure 9, step 4). Parts whose
    /// bounds keep the clearance are not looked at any closer.
    fn interferes(&mut self, item: usize, candidate: &Candidate) -> bool {
        let hit = |layout: &Self, other: &Placed| {
            let clearance_mm = layout.instance.clearance_between_mm(item, other.placement.item);
            let gap_mm = candidate.bounds.distance(&other.bounds);
            if gap_mm >= clearance_mm && gap_mm > 0.0 {
                return false;
            }
            let boxes = &layout.shapes[other.placement.item].boxes;
            boxes.collides(&layout.shapes[item].boxes, &other.placement.pose.seen(&candidate.pose), clearance_mm)
        };
        if self.is_in_a_zone(item, candidate) {
            return true;
        }
        if self.placed.get(self.obstacle).is_some_and(|other| hit(self, other)) {
            return true;
        }
        let found = (self.placed.iter().enumerate()).find(|&(i, other)| i != self.obstacle && hit(self, other));
        if let Some((obstacle, _)) = found {
            self.obstacle = obstacle;
            return true;
        }
        false
    }

    fn is_in_a_zone(&self, item: usize, candidate: &Candidate) -> bool {
        self.zones.meet(&self.shapes[item].surface, &candidate.pose, &candidate.bounds)
    }

    /// Whether the candidate is wholly inside a placed part, or the other way round: boxes cover surfaces and do not see it.
    fn is_nested(&self, item: usize, candidate: &Candidate) -> bool {
        let surface = &self.shapes[item].surface;
        self.placed.iter().filter(|p| p.bounds.distance(&candidate.bounds) <= 0.0).any(|p| {
            let other = &self.shapes[p.placement.item].surface;
            let pose12 = p.placement.pose.seen(&candidate.pose);
            other.holds_part(surface, &pose12) || surface.holds_part(other, &pose12.inverse())
        })
    }

    /// Whether the candidate or a placed part could be raised against the other: boxes do not look at that.
    fn is_near_when_raised(&self, item: usize, candidate: &Candidate) -> bool {
        if self.instance.clearance_z_extra_mm() <= 0.0 {
            return false;
        }
        let clear = |p: &Placed| {
            let (one, two) =
                ((item, &candidate.pose, &candidate.bounds), (p.placement.item, &p.placement.pose, &p.bounds));
            keeps_apart(self.instance, self.shapes, one, two)
        };
        !self.placed.iter().all(clear)
    }

    /// What the candidate fills in each layer.
    fn slice(&self, item: usize, candidate: &Candidate) -> Slice {
        Slice::of(&self.instance.items()[item].mesh, &candidate.pose, self.instance.layer_cap().layer_mm)
    }

    fn put(&mut self, item: usize, copy: u32, candidate: &Candidate) {
        if self.filled.is_capped() {
            self.filled.add(&self.slice(item, candidate));
        }
        let placement = Placement { item, copy, pose: candidate.pose };
        self.top_mm = self.top_mm.max(candidate.bounds.max.z);
        self.placed.push(Placed { placement, bounds: candidate.bounds });
    }
}
