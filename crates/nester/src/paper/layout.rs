//! One layout of the paper's method: parts in sequence, each placed by its own flower pollination.

use glam::DVec3;
use solids::{Bounds, Pose};

use super::{clearance_check::surfaces_keep_clearance, shape::PaperShape, zone_obstacles::ZoneObstacles};
use crate::{
    ItemPlacement, NestingInstance, PaperConfig, StopCondition,
    pollination::{FlowerPollination, GeneBoundary, GeneRange, PollinationSettings},
    prepare::layers::{FilledLayers, PartLayerAreas},
};

/// Number of times that a flower whose proposal interferes is redrawn within one turn. Step 4 of figure 9 repeats
/// without a limit, which would never end in a full container.
const REDRAWS: usize = 8;
/// Proposals between two checks of the budget.
const PROPOSALS_PER_CHECK: u64 = 16;
/// Number of genes that encode the position.
const POSITION_GENES: usize = 3;

/// Height of the layout with this part, then its distance from the origin, mm.
type LayoutFitness = (f64, f64);

/// A layout under construction.
pub(super) struct PaperLayout<'a> {
    instance: &'a NestingInstance,
    shapes: &'a [PaperShape],
    zones: &'a ZoneObstacles,
    placed: Vec<BoundedPlacement>,
    top_mm: f64,
    filled: FilledLayers,
    /// The placed part that interfered last; it is tested first.
    obstacle: usize,
}

struct BoundedPlacement {
    placement: ItemPlacement,
    bounds: Bounds,
}

/// A candidate pose and its fitness.
struct CandidatePose {
    pose: Pose,
    bounds: Bounds,
    fitness: LayoutFitness,
}

/// The budget for placing one part.
pub(super) struct PlacementBudget<'a> {
    /// The budget.
    pub stop: &'a dyn StopCondition,
    /// The share of the budget at which the part must be placed.
    pub until: f64,
}

impl<'a> PaperLayout<'a> {
    /// An empty layout.
    pub fn new(instance: &'a NestingInstance, shapes: &'a [PaperShape], zones: &'a ZoneObstacles) -> Self {
        let filled = FilledLayers::new(instance.layer_cap());
        Self { instance, shapes, zones, placed: Vec::new(), top_mm: 0.0, filled, obstacle: 0 }
    }

    /// Places fixed copies at their poses.
    pub fn add_pinned(&mut self, pinned: &[ItemPlacement]) {
        for &placement in pinned.iter().filter(|p| p.item < self.shapes.len()) {
            let bounds = self.shapes[placement.item].surface.bounds_at(&placement.pose);
            self.top_mm = self.top_mm.max(bounds.max.z);
            self.placed.push(BoundedPlacement { placement, bounds });
        }
    }

    /// Placed copies in the order of placement.
    pub fn placements(&self) -> Vec<ItemPlacement> {
        self.placed.iter().map(|p| p.placement).collect()
    }

    /// Places the first part in the corner at the origin, in its initial orientation or rotated by 90 degrees. Returns
    /// whether it fits.
    pub fn place_in_corner(&mut self, item: usize, copy: u32) -> bool {
        let fit = (0..2).find_map(|quarters| {
            let mut genome = vec![0.0; POSITION_GENES];
            genome.extend(self.shapes[item].initial_genes(quarters));
            self.decode_candidate(item, &genome)
        });
        match fit {
            Some(candidate)
                if self.placed.is_empty()
                    && !self.is_in_a_zone(item, &candidate)
                    && self.filled.can_add(&self.candidate_layer_areas(item, &candidate)) =>
            {
                self.add_candidate(item, copy, &candidate);
                true
            }
            _ => false,
        }
    }

    /// Finds a place by flower pollination (section 2.3.1, steps 1 to 8). Returns whether there is one. Counts
    /// proposals in `evaluations`.
    pub fn place_copy(
        &mut self,
        (item, copy): (usize, u32),
        config: &PaperConfig,
        pace: &PlacementBudget,
        seed: u64,
        evaluations: &mut u64,
    ) -> bool {
        let setup = PollinationSettings {
            population: config.population,
            switch_probability: config.switch_probability,
            scale: config.scale,
            levy_exponent: config.levy_exponent,
            even: false,
        };
        let place = GeneRange { lower: 0.0, upper: 1.0, edge: GeneBoundary::Clamp };
        let genes = [vec![place; POSITION_GENES], self.shapes[item].rotation_genes()].concat();
        let mut search =
            FlowerPollination::new(setup, genes, seed).starting_at(self.start_genomes(item, config.population));
        let mut found: Option<CandidatePose> = None;
        let turns = config.population.max(1) as u64 * (config.iterations as u64 + 1);
        let start = *evaluations;
        for turn in 0..turns {
            if turn.is_multiple_of(PROPOSALS_PER_CHECK)
                && *evaluations > start + 4
                && pace.stop.spent_share_at(*evaluations) >= pace.until
            {
                break;
            }
            if let Some(better) = self.take_flower_turn(item, &mut search, evaluations) {
                found = Some(better);
            }
        }
        if let Some(candidate) = &found {
            self.add_candidate(item, copy, candidate);
        }
        found.is_some()
    }

    /// Takes one flower's turn. Returns the candidate when it is the best so far.
    fn take_flower_turn(
        &mut self,
        item: usize,
        search: &mut FlowerPollination<LayoutFitness>,
        evaluations: &mut u64,
    ) -> Option<CandidatePose> {
        for _ in 0..=REDRAWS {
            *evaluations += 1;
            let candidate = self.decode_candidate(item, search.ask());
            let Some(candidate) = candidate else { continue };
            // The objective costs far less than the interference test. A place that is no better than the flower's own
            // would be refused anyway, so it ends the turn untested.
            if search.own_fitness().is_some_and(|own| candidate.fitness >= *own) {
                break;
            }
            if self.interferes(item, &candidate) {
                continue;
            }
            let is_best = search.best().is_none_or(|(_, best)| candidate.fitness < *best);
            let is_barred = || {
                self.is_nested(item, &candidate)
                    || self.is_near_when_raised(item, &candidate)
                    || self.filled.is_capped() && !self.filled.can_add(&self.candidate_layer_areas(item, &candidate))
            };
            if is_best && is_barred() {
                continue;
            }
            return search.tell(candidate.fitness).then_some(candidate);
        }
        search.skip_turn();
        None
    }

    /// Start positions of the first flowers: on top of everything in the corner at the origin, on the floor there, then
    /// scattered over the container in the initial orientation. The other half of the flowers starts anywhere in any
    /// orientation.
    fn start_genomes(&self, item: usize, population: usize) -> Vec<Vec<f64>> {
        // Steps of the three-dimensional generalisation of the golden ratio scatter more evenly than random numbers.
        let kin = [0.819_172_513_396_164_4, 0.671_043_606_703_789_3, 0.549_700_477_901_970_3];
        let flowers = population.div_ceil(2).max(4);
        let place = |flower: usize| match flower {
            0 | 1 => [0.0, 0.0, 1.0],
            2 | 3 => [0.0; POSITION_GENES],
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

    /// Decodes a genome; `None` when its orientation is too large for the container. Position genes are shares of the
    /// range in which the part fits within the walls; in z, up to just above the highest part.
    fn decode_candidate(&self, item: usize, genome: &[f64]) -> Option<CandidatePose> {
        let shape = &self.shapes[item];
        let rotation = shape.decode_rotation(&genome[POSITION_GENES..]);
        if !shape.allows_rotation(rotation) {
            return None;
        }
        let bounds = shape.surface.bounds_at(&Pose { rotation, translation: DVec3::ZERO });
        let mut free = self.instance.volume().size_mm - bounds.size();
        // A part exactly as large as the container fits, in spite of rounding.
        if free.min_element() < -1e-9 {
            return None;
        }
        free = free.max(DVec3::ZERO);
        free.z = free.z.min(self.above_all_mm(item));
        let corner = DVec3::new(genome[0], genome[1], genome[2]) * free;
        let translation = corner - bounds.min;
        let bounds = Bounds { min: corner, max: bounds.max + translation };
        let fitness = (self.top_mm.max(bounds.max.z), bounds.max.length());
        Some(CandidatePose { pose: Pose { rotation, translation }, bounds, fitness })
    }

    /// The height at which no part can interfere any more, mm. Slightly more than the clearance, in spite of rounding.
    fn above_all_mm(&self, item: usize) -> f64 {
        let extra_mm = self.instance.clearance_z_extra_mm();
        let clear = |p: &BoundedPlacement| {
            p.bounds.max.z + self.instance.clearance_between_mm(item, p.placement.item) + extra_mm + 1e-6
        };
        self.placed.iter().map(clear).fold(self.zones.top_mm(), f64::max)
    }

    /// Whether the candidate's boxes come too near to those of a placed part (figure 9, step 4). Parts whose bounds
    /// keep the clearance are not tested further.
    fn interferes(&mut self, item: usize, candidate: &CandidatePose) -> bool {
        let hit = |layout: &Self, other: &BoundedPlacement| {
            let clearance_mm = layout.instance.clearance_between_mm(item, other.placement.item);
            let gap_mm = candidate.bounds.distance(&other.bounds);
            if gap_mm >= clearance_mm && gap_mm > 0.0 {
                return false;
            }
            let boxes = &layout.shapes[other.placement.item].boxes;
            boxes.collides_with(
                &layout.shapes[item].boxes,
                &other.placement.pose.relative_pose_of(&candidate.pose),
                clearance_mm,
            )
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

    fn is_in_a_zone(&self, item: usize, candidate: &CandidatePose) -> bool {
        self.zones.intersect_part(&self.shapes[item].surface, &candidate.pose, &candidate.bounds)
    }

    /// Whether the candidate is wholly inside a placed part, or the other way round. Boxes cover only surfaces and do
    /// not detect this.
    fn is_nested(&self, item: usize, candidate: &CandidatePose) -> bool {
        let surface = &self.shapes[item].surface;
        self.placed.iter().filter(|p| p.bounds.distance(&candidate.bounds) <= 0.0).any(|p| {
            let other = &self.shapes[p.placement.item].surface;
            let pose12 = p.placement.pose.relative_pose_of(&candidate.pose);
            other.contains_part(surface, &pose12) || surface.contains_part(other, &pose12.inverse())
        })
    }

    /// Whether raising the candidate or a placed part would break the clearance. Boxes do not test this.
    fn is_near_when_raised(&self, item: usize, candidate: &CandidatePose) -> bool {
        if self.instance.clearance_z_extra_mm() <= 0.0 {
            return false;
        }
        let clear = |p: &BoundedPlacement| {
            let (one, two) =
                ((item, &candidate.pose, &candidate.bounds), (p.placement.item, &p.placement.pose, &p.bounds));
            surfaces_keep_clearance(self.instance, self.shapes, one, two)
        };
        !self.placed.iter().all(clear)
    }

    /// The area that the candidate fills in each layer.
    fn candidate_layer_areas(&self, item: usize, candidate: &CandidatePose) -> PartLayerAreas {
        PartLayerAreas::from_mesh(
            &self.instance.items()[item].mesh,
            &candidate.pose,
            self.instance.layer_cap().layer_mm,
        )
    }

    fn add_candidate(&mut self, item: usize, copy: u32, candidate: &CandidatePose) {
        if self.filled.is_capped() {
            self.filled.add_part(&self.candidate_layer_areas(item, candidate));
        }
        let placement = ItemPlacement { item, copy, pose: candidate.pose };
        self.top_mm = self.top_mm.max(candidate.bounds.max.z);
        self.placed.push(BoundedPlacement { placement, bounds: candidate.bounds });
    }
}
