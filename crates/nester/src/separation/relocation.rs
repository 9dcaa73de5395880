//! Finds another place for a part. Flower pollination searches the whole volume in three steps of rising cost: many
//! lookups in the overlap depth grid, the overlap of the best candidates, and separation steps for the very best.

use glam::{DQuat, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{
    overlap_depth_grid::OverlapDepthGrid,
    separation_step::CollisionProxy,
    working_layout::{CenterPose, WorkingLayout},
};
use crate::{
    OrientationLimits, OrientationRule,
    orientation::first_rotations::first_rotations,
    pollination::{FlowerPollination, GeneBoundary, GeneRange, PollinationSettings},
};

/// Number of flowers of a part that are kept for its next relocation.
const KEPT_FLOWERS: usize = 16;
/// Candidates whose centers are nearer to each other than this, relative to the part's radius,
const SAME_PLACE: f64 = 0.3;
/// and whose rotations differ by less than this, radians, are one place.
const SAME_ROTATION: f64 = 0.3;

/// Decodes the rotation of a part from a genome.
struct RotationDecoder<'t> {
    orientation: &'t OrientationLimits,
    bases: Vec<DQuat>,
}

impl<'t> RotationDecoder<'t> {
    fn new(layout: &WorkingLayout<'t>, part: usize) -> Self {
        let kind = layout.prepared.prepared_item(layout.parts.copies[part].0);
        let room = layout.prepared.room.with_z(layout.height_limit_mm);
        let mut bases = match kind.orientation.rule {
            OrientationRule::Fixed => vec![DQuat::IDENTITY],
            _ => first_rotations(&kind.orientation, kind.shape.frame, &kind.shape.extremes, room, 24),
        };
        bases.push(layout.poses[part].rotation);
        Self { orientation: &kind.orientation, bases }
    }

    fn gene_ranges(&self) -> Vec<GeneRange> {
        let gene = |upper: f64, edge: GeneBoundary| GeneRange { lower: 0.0, upper, edge };
        let turning = [
            gene(2.0, GeneBoundary::Wrap),
            gene(1.0, GeneBoundary::Reflect),
            gene(1.0, GeneBoundary::Wrap),
            gene(1.0, GeneBoundary::Wrap),
        ];
        turning.into_iter().chain([gene(1.0, GeneBoundary::Reflect); 3]).collect()
    }

    /// A first gene below 1 selects one of the base rotations. Above 1, the next three genes define a rotation, within
    /// the rule.
    fn decode_rotation(&self, genome: &[f64]) -> DQuat {
        let base = |share: f64| self.bases[((share * self.bases.len() as f64) as usize).min(self.bases.len() - 1)];
        match self.orientation.rule {
            _ if genome[0] < 1.0 => base(genome[0]),
            OrientationRule::Free => {
                let genes = [genome[1], genome[2], genome[3]];
                self.orientation.rotation_from_genes(genes).unwrap_or_else(|| base(genome[0] - 1.0))
            }
            OrientationRule::Upright => DQuat::from_rotation_z(genome[2] * std::f64::consts::TAU),
            OrientationRule::Axis | OrientationRule::Fixed => base(genome[0] - 1.0),
        }
    }
}

/// Returns a random pose of a part in the room, at a random rotation that its rule allows. Returns the present pose if
/// that rotation does not fit.
pub(crate) fn random_pose(layout: &WorkingLayout<'_>, part: usize, rng: &mut ChaCha8Rng) -> CenterPose {
    let turning = RotationDecoder::new(layout, part);
    let genome: Vec<f64> = turning.gene_ranges().iter().map(|gene| rng.random_range(gene.lower..gene.upper)).collect();
    let turn = turning.decode_rotation(&genome);
    let mut proxy = layout.proxies[part].clone();
    proxy.set_pose(turn, DVec3::ZERO);
    let (min, max) = (proxy.min.as_dvec3(), proxy.max.as_dvec3());
    let free = layout.prepared.room.with_z(layout.height_limit_mm) - (max - min);
    if free.min_element() < 0.0 {
        return layout.poses[part];
    }
    CenterPose { rotation: turn, center: DVec3::new(genome[4], genome[5], genome[6]) * free - min }
}

/// Limits on the work of one relocation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RelocationEffort {
    /// Number of queries to the overlap depth grid.
    pub(crate) grid_queries: usize,
    /// Number of candidates compared by coarse overlap.
    pub(crate) coarse_checks: usize,
    /// Number of candidates improved by separation steps.
    pub(crate) separated: usize,
}

/// Moves a part to the best other place found, even if it is no better.
pub(crate) fn move_elsewhere(
    layout: &mut WorkingLayout<'_>,
    grid: &mut OverlapDepthGrid,
    part: usize,
    effort: RelocationEffort,
    rng: &mut ChaCha8Rng,
) {
    relocate_part(layout, grid, part, effort, f32::INFINITY, rng);
}

/// Moves a part to a better place if there is one: the best found that has less weighted overlap than `energy`.
pub(crate) fn relocate_part(
    layout: &mut WorkingLayout<'_>,
    grid: &mut OverlapDepthGrid,
    part: usize,
    effort: RelocationEffort,
    energy: f32,
    rng: &mut ChaCha8Rng,
) -> bool {
    grid.update_parts(layout, part);
    let turning = RotationDecoder::new(layout, part);
    let mut proxy = layout.proxies[part].clone();
    let candidates = propose_poses(layout, part, grid, &turning, &mut proxy, effort, rng);
    layout.evaluations += (effort.grid_queries / 40) as u64;
    let mut ranked: Vec<(f32, CenterPose)> = Vec::with_capacity(candidates.len());
    for pose in candidates {
        let least = if ranked.len() < effort.separated { f32::INFINITY } else { ranked[effort.separated - 1].0 };
        let pose = layout.clamp_to_room(&mut proxy, pose);
        layout.evaluations += 1;
        let energy = layout.energy_at(part, &proxy, true, least);
        if energy < least {
            let at = ranked.partition_point(|(known, _)| *known <= energy);
            ranked.insert(at, (energy, pose));
            ranked.truncate(effort.separated);
        }
    }
    let here = layout.poses[part];
    let mut best = (energy, here);
    for (_, pose) in ranked {
        layout.move_part(part, pose);
        for _ in 0..5 {
            if layout.take_separation_step(part) <= 0.0 {
                break;
            }
        }
        let energy = layout.energy_at(part, &layout.proxies[part], false, best.0);
        if energy < best.0 {
            best = (energy, layout.poses[part]);
            if energy <= 0.0 {
                break;
            }
        }
    }
    layout.move_part(part, best.1);
    best.1.center != here.center
}

/// The best poses of a part, each in another place. Without this rule, nearly all of them would be in the place that the
/// part is to leave: nothing else stands there.
struct DifferentPlaces {
    /// Depths and poses, the least depth first.
    ranked: Vec<(f64, CenterPose)>,
    most: usize,
    near_mm: f64,
}

impl DifferentPlaces {
    /// Room for `most` poses of a part with this radius.
    fn new(most: usize, radius_mm: f64) -> Self {
        Self { ranked: Vec::with_capacity(most + 1), most, near_mm: SAME_PLACE * radius_mm }
    }

    /// The depth from which on a pose is not kept.
    fn worst_depth(&self) -> f64 {
        if self.ranked.len() < self.most { f64::INFINITY } else { self.ranked.last().map_or(0.0, |(worst, _)| *worst) }
    }

    /// Keeps a pose if it is one of the best, and the best of its place.
    fn offer_pose(&mut self, depth: f64, pose: CenterPose) {
        if depth >= self.worst_depth() {
            return;
        }
        let is_same = |known: &CenterPose| {
            known.center.distance_squared(pose.center) < self.near_mm * self.near_mm
                && known.rotation.angle_between(pose.rotation) < SAME_ROTATION
        };
        if self.ranked.iter().any(|(known, at)| *known <= depth && is_same(at)) {
            return;
        }
        self.ranked.retain(|(_, at)| !is_same(at));
        let at = self.ranked.partition_point(|(known, _)| *known <= depth);
        self.ranked.insert(at, (depth, pose));
        self.ranked.truncate(self.most);
    }
}

/// Returns the best poses that flower pollination found, by overlap depth, each in another place.
fn propose_poses(
    layout: &mut WorkingLayout<'_>,
    part: usize,
    grid: &OverlapDepthGrid,
    turning: &RotationDecoder<'_>,
    proxy: &mut CollisionProxy,
    effort: RelocationEffort,
    rng: &mut ChaCha8Rng,
) -> Vec<CenterPose> {
    let even = !layout.prepared.components.flowers_in_relocation;
    let setup = PollinationSettings { population: 40, switch_probability: 0.4, even, ..PollinationSettings::default() };
    // The layout changes little between two relocations of a part, so the search continues from its best flowers.
    let before = if even { Vec::new() } else { std::mem::take(&mut layout.flowers[part]) };
    let mut flowers = FlowerPollination::new(setup, turning.gene_ranges(), rng.random()).starting_at(before);
    let room = layout.prepared.room.with_z(layout.height_limit_mm);
    let mut best = DifferentPlaces::new(effort.coarse_checks, proxy.shape.radius_mm);
    for _ in 0..effort.grid_queries {
        let genome = flowers.ask();
        let turn = turning.decode_rotation(genome);
        let share = DVec3::new(genome[4], genome[5], genome[6]);
        proxy.set_pose(turn, DVec3::ZERO);
        let (min, max) = (proxy.min.as_dvec3(), proxy.max.as_dvec3());
        let free = room - (max - min);
        if free.min_element() < 0.0 {
            flowers.tell(1e9 - free.min_element());
            continue;
        }
        let place = share * free - min;
        proxy.center = place.as_vec3();
        let worst = best.worst_depth();
        // The exact depth matters where it is better than the flower's own or than one of the best.
        let depth = grid.mean_depth(proxy, flowers.own_fitness().map_or(f64::INFINITY, |own| own.max(worst)));
        flowers.tell(depth);
        best.offer_pose(depth, CenterPose { rotation: turn, center: place });
    }
    if !even {
        layout.flowers[part] = flowers.ranked_genomes().into_iter().take(KEPT_FLOWERS).map(<[f64]>::to_vec).collect();
    }
    best.ranked.into_iter().map(|(_, pose)| pose).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_each_place_only_the_best_pose_is_kept() {
        let pose = |x: f64, angle: f64| CenterPose { rotation: DQuat::from_rotation_z(angle), center: DVec3::X * x };
        let mut places = DifferentPlaces::new(3, 10.0);
        for (depth, x, angle) in [(5.0, 0.0, 0.0), (4.0, 2.0, 0.1), (6.0, 1.0, 0.1), (7.0, 1.0, 1.0), (8.0, 9.0, 0.1)] {
            places.offer_pose(depth, pose(x, angle));
        }
        let depths = |places: &DifferentPlaces| places.ranked.iter().map(|place| place.0).collect::<Vec<_>>();
        assert_eq!((depths(&places), places.worst_depth()), (vec![4.0, 7.0, 8.0], 8.0));
        // A better pose of another place takes the place of the worst; a worse one is not kept.
        places.offer_pose(9.0, pose(50.0, 0.0));
        places.offer_pose(1.0, pose(30.0, 0.0));
        assert_eq!(depths(&places), [1.0, 4.0, 7.0]);
        // A pose between two kept ones takes the place of both if it is better.
        let mut places = DifferentPlaces::new(3, 10.0);
        [(5.0, 0.0), (6.0, 4.0), (4.0, 2.0)].into_iter().for_each(|(depth, x)| places.offer_pose(depth, pose(x, 0.0)));
        assert_eq!(depths(&places), [4.0]);
    }
}
