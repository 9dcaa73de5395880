//! The layout during the search. Overlaps are allowed and penalised, and so is what does not fit between the walls, the
//! floor and the height limit. A part that fits is always inside.

mod confirmation;
mod joint_steps;
mod part_steps;
mod walls;

use glam::{DQuat, DVec3, Vec3};

use super::{
    disassembly::{DisassemblyPlan, plan_disassembly},
    exact_contacts,
    interlock_memory::InterlockMemory,
    layout_parts::LayoutParts,
    pair_records::{MAX_WEIGHT, PairConstraint, PairRecordTable, WEIGHT_DECAY},
    proximity_grid::ProximityGrid,
    separation_step::CollisionProxy,
};
use crate::{
    OrientationRule,
    prepare::prepared_instance::{PlacedItem, PreparedInstance, clearance_of_pair},
    problem::fit_check::shift_inside,
};
use walls::WallRecord;

/// Distance that proxies keep from the walls, mm: their bounds have single precision.
const PROXY_SPARE_MM: f32 = 2e-4;
/// Up to this number of parts, testing all of them is faster than a grid.
const GRID_MIN_PARTS: usize = 100;
/// Distance beyond the clearance that the search aims at, mm.
const CLEARANCE_TARGET_SPARE_MM: f32 = 2e-3;
/// Greatest correction of the proxies for a pair, mm.
const MAX_MARGIN_MM: f32 = 1.5;

/// The pose of one part, as rotation and center. The rotation has full precision.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CenterPose {
    pub(crate) rotation: DQuat,
    pub(crate) center: DVec3,
}

/// The layout during the search.
#[derive(Debug, Clone)]
pub(crate) struct WorkingLayout<'t> {
    pub(crate) prepared: &'t PreparedInstance,
    /// What does not change while parts move.
    pub(crate) parts: LayoutParts,
    pub(crate) poses: Vec<CenterPose>,
    pub(crate) proxies: Vec<CollisionProxy>,
    /// Heights at which overlap is tested, mm. Only 0 when clearances need not hold for raised parts.
    raise_offsets: Vec<f32>,
    pair_records: PairRecordTable,
    /// For each part, what is known of it and the walls.
    walls: Vec<WallRecord>,
    /// Number of moves of each part.
    move_counts: Vec<u32>,
    /// Each part as it was last placed, with its move count then.
    placed: Vec<Option<(u32, PlacedItem)>>,
    /// Pairs of parts that were interlocked.
    pub(crate) interlock_memory: InterlockMemory,
    /// The best flowers of each part's last relocation.
    pub(crate) flowers: Vec<Vec<Vec<f64>>>,
    /// Grid of the parts by place, used when there are many parts.
    grid: Option<ProximityGrid>,
    /// Height limit, mm.
    pub(crate) height_limit_mm: f64,
    /// Number of evaluations of one part among its neighbours.
    pub(crate) evaluations: u64,
}

impl<'t> WorkingLayout<'t> {
    /// Creates the layout of pieces below a height limit.
    pub(crate) fn new(task: &'t PreparedInstance, pieces: &[PlacedItem], height_limit_mm: f64) -> Self {
        let proxy =
            |p: &PlacedItem| CollisionProxy::new(task.prepared_item(p.item).shape.clone(), p.rotation, p.center);
        let parts = || pieces.iter().chain(&task.zones);
        let proxies: Vec<CollisionProxy> = parts().map(proxy).collect();
        let grid = (proxies.len() > GRID_MIN_PARTS).then(|| {
            let mut grid = ProximityGrid::new(task.room);
            proxies.iter().enumerate().for_each(|(part, proxy)| grid.insert_bounds(part, &proxy.bounds()));
            grid
        });
        Self {
            prepared: task,
            grid,
            parts: LayoutParts {
                copies: parts().map(|p| (p.item, p.copy)).collect(),
                clearances: parts().map(|p| task.prepared_item(p.item).clearance_mm as f32).collect(),
                fixed: parts().map(|p| task.is_fixed((p.item, p.copy))).collect(),
                copy_count: pieces.len(),
            },
            poses: parts().map(|p| CenterPose { rotation: p.rotation, center: p.center }).collect(),
            raise_offsets: task.raise_offsets(),
            pair_records: PairRecordTable::new(proxies.len()),
            walls: vec![WallRecord::NONE; proxies.len()],
            move_counts: vec![0; proxies.len()],
            placed: vec![None; proxies.len()],
            flowers: vec![Vec::new(); proxies.len()],
            proxies,
            interlock_memory: InterlockMemory::new(),
            height_limit_mm,
            evaluations: 0,
        }
    }

    /// Number of parts.
    pub(crate) fn part_count(&self) -> usize {
        self.poses.len()
    }

    /// Moves all parts to the given poses.
    pub(crate) fn load_poses(&mut self, poses: &[CenterPose]) {
        for (part, pose) in poses.iter().enumerate() {
            self.move_part(part, *pose);
        }
    }

    /// Puts all parts back to where they stood. Unlike a part that is moved, none is shifted inside the walls: a shift
    /// by less than a micron between two fixed parts would break their clearance, and nobody checks it again.
    pub(crate) fn restore_parts(&mut self, poses: &[CenterPose], proxies: &[CollisionProxy]) {
        for (part, (pose, proxy)) in poses.iter().zip(proxies).enumerate() {
            let known = self.poses[part];
            if known.center == pose.center && known.rotation == pose.rotation {
                continue;
            }
            self.move_counts[part] = self.move_counts[part].wrapping_add(1);
            self.poses[part] = *pose;
            let before = std::mem::replace(&mut self.proxies[part], proxy.clone());
            if let Some(grid) = &mut self.grid {
                grid.remove_bounds(part, &before.bounds());
                grid.insert_bounds(part, &proxy.bounds());
            }
        }
    }

    /// The orientation rule of a part.
    pub(crate) fn orientation_rule(&self, part: usize) -> OrientationRule {
        self.prepared.prepared_item(self.parts.copies[part].0).orientation.rule
    }

    /// Moves a part, then shifts it inside the walls if it fits.
    pub(crate) fn move_part(&mut self, part: usize, pose: CenterPose) {
        if self.parts.fixed[part] {
            return;
        }
        let mut proxy = self.proxies[part].clone();
        let mut pose = self.clamp_to_room(&mut proxy, pose);
        let known = self.poses[part];
        if known.center == pose.center && known.rotation == pose.rotation {
            return;
        }
        // The proxy's bounds come from some points only; the bounds of the triangles are exact.
        let exact = proxy.shape.tree.bounds_at(&proxy.shape.mesh_pose(pose.rotation, pose.center));
        let shift = shift_inside(&exact, self.prepared.room.with_z(self.height_limit_mm));
        pose.center += shift;
        proxy.center = pose.center.as_vec3();
        (proxy.min, proxy.max) = ((exact.min + shift).as_vec3(), (exact.max + shift).as_vec3());
        self.move_counts[part] = self.move_counts[part].wrapping_add(1);
        self.poses[part] = pose;
        let before = std::mem::replace(&mut self.proxies[part], proxy);
        if let Some(grid) = &mut self.grid {
            grid.remove_bounds(part, &before.bounds());
            grid.insert_bounds(part, &self.proxies[part].bounds());
        }
    }

    /// Sets a proxy to a pose and shifts it inside the walls. A part that is too long stands out at the far end.
    pub(crate) fn clamp_to_room(&self, proxy: &mut CollisionProxy, pose: CenterPose) -> CenterPose {
        proxy.set_pose(pose.rotation, pose.center);
        let room = self.prepared.room.with_z(self.height_limit_mm).as_vec3() - PROXY_SPARE_MM;
        // The proxies know their bounds to about a micron (single precision); the exact bounds are checked later.
        let shift = (room - proxy.max).min(Vec3::ZERO);
        let shift = shift + (PROXY_SPARE_MM - (proxy.min + shift)).max(Vec3::ZERO);
        if shift == Vec3::ZERO {
            return pose;
        }
        let pose = CenterPose { rotation: pose.rotation, center: pose.center + shift.as_dvec3() };
        proxy.center += shift;
        proxy.min += shift;
        proxy.max += shift;
        pose
    }

    /// The clearance, weight and contacts that apply between two parts.
    pub(crate) fn pair_constraint(&self, one: usize, other: usize) -> PairConstraint<'_> {
        let (one_mm, other_mm) = (f64::from(self.parts.clearances[one]), f64::from(self.parts.clearances[other]));
        let clearance = clearance_of_pair(one_mm, other_mm) as f32 + CLEARANCE_TARGET_SPARE_MM;
        match self.pair_records.get_pair(one, other) {
            Some(record) => PairConstraint {
                reach: clearance + record.margin,
                clearance,
                weight: record.weight,
                contacts: &record.contacts,
            },
            None => PairConstraint { reach: clearance, clearance, weight: 1.0, contacts: &[] },
        }
    }

    /// Unweighted overlap of a part, if it were at `proxy`, with another part.
    fn pair_overlap(
        &self,
        part: usize,
        proxy: &CollisionProxy,
        other: usize,
        wanted: &PairConstraint<'_>,
        coarse: bool,
    ) -> f32 {
        let there = &self.proxies[other];
        let once = |proxy: &CollisionProxy| match coarse {
            true => proxy.coarse_overlap_energy(there, wanted.reach),
            false => proxy.overlap_energy(there, wanted.reach),
        };
        let energy: f32 = match self.raise_offsets[..] {
            [_] => once(proxy),
            _ => self.raise_offsets.iter().map(|&lift| once(&proxy.raised_by(lift))).sum(),
        };
        let energy = energy + self.interlock_memory.penetration_energy((part, proxy), (other, there));
        if wanted.contacts.is_empty() {
            return energy;
        }
        let (first, second) = if part < other { (proxy, there) } else { (there, proxy) };
        energy + exact_contacts::contact_energy(wanted.contacts, first, second, wanted.clearance)
    }

    /// Distance of bounds below which a pair is tested.
    fn proximity_reach(&self) -> f32 {
        (self.prepared.max_clearance_mm + self.prepared.z_extra_mm) as f32 + MAX_MARGIN_MM
    }

    /// Parts whose bounds are within the test distance of a proxy, in rising order.
    fn nearby_parts<'a>(&'a self, part: usize, proxy: &'a CollisionProxy) -> impl Iterator<Item = usize> + use<'a, 't> {
        let reach = self.proximity_reach();
        let around = self.grid.as_ref().map(|grid| grid.query_near(&proxy.bounds(), f64::from(reach)));
        let all = if around.is_some() { 0..0 } else { 0..self.part_count() };
        let candidates = around.unwrap_or_default().into_iter().chain(all);
        candidates.filter(move |&other| other != part && proxy.is_near(&self.proxies[other], reach))
    }

    /// Pairs whose bounds are within the test distance, without duplicates, in rising order.
    fn nearby_pairs(&self) -> Vec<(usize, usize)> {
        let of = |one: usize| {
            self.nearby_parts(one, &self.proxies[one])
                .filter(move |&other| other > one && !self.are_fixed(one, other))
                .map(move |o| (one, o))
        };
        (0..self.part_count()).flat_map(of).collect()
    }

    /// How far a part, if it were at `proxy`, stands out of the walls and of the height limit along each axis, mm.
    fn excess_mm(&self, part: usize, proxy: &CollisionProxy) -> Vec3 {
        self.walls[part].excess_mm(proxy, self.prepared.room.with_z(self.height_limit_mm).as_vec3())
    }

    /// The same in the unit of overlap, unweighted.
    fn excess_energy(&self, part: usize, proxy: &CollisionProxy) -> f32 {
        self.excess_mm(part, proxy).length() * (proxy.shape.radius_mm as f32).powi(2)
    }

    /// The same with its weight.
    fn weighted_excess(&self, part: usize, proxy: &CollisionProxy) -> f32 {
        self.walls[part].weight * self.excess_energy(part, proxy)
    }

    /// Weighted overlap of a part, if it were at `proxy`; stops summing at `enough`.
    pub(crate) fn energy_at(&self, part: usize, proxy: &CollisionProxy, coarse: bool, enough: f32) -> f32 {
        let mut energy = self.weighted_excess(part, proxy);
        for other in self.nearby_parts(part, proxy) {
            let wanted = self.pair_constraint(part, other);
            energy += wanted.weight * self.pair_overlap(part, proxy, other, &wanted, coarse);
            if energy >= enough {
                break;
            }
        }
        energy
    }

    /// Whether both parts are fixed: then an overlap between them cannot be resolved.
    fn are_fixed(&self, one: usize, other: usize) -> bool {
        self.parts.fixed[one] && self.parts.fixed[other]
    }

    /// Unweighted overlap of two parts at their present poses; cached until one of them moves.
    fn pair_energy(&mut self, one: usize, other: usize) -> f32 {
        let now = (self.move_counts[one], self.move_counts[other]);
        if let Some((at, energy)) = self.pair_records.get_pair(one, other).and_then(|record| record.known_overlap)
            && at == now
        {
            return energy;
        }
        let energy = self.pair_overlap(one, &self.proxies[one], other, &self.pair_constraint(one, other), false);
        self.pair_records.pair_or_insert(one, other).known_overlap = Some((now, energy));
        energy
    }

    /// Computes the unweighted overlap of every part, summed over its pairs. Pair weights grow where there is overlap
    /// and decay elsewhere.
    pub(crate) fn weigh_overlaps(&mut self, energies: &mut Vec<f32>) -> f32 {
        energies.clear();
        energies.resize(self.part_count(), 0.0);
        let mut pairs: Vec<(usize, usize, f32)> = Vec::new();
        for (part, energy) in energies.iter_mut().enumerate().take(self.parts.copy_count) {
            *energy += self.excess_energy(part, &self.proxies[part]);
            if self.prepared.components.weights {
                self.walls[part].weigh(*energy > 0.0);
            }
        }
        for (one, other) in self.nearby_pairs() {
            let energy = self.pair_energy(one, other);
            if energy > 0.0 {
                energies[one] += energy;
                energies[other] += energy;
                pairs.push((one, other, energy));
            }
        }
        self.evaluations += self.part_count() as u64 / 2 + 1;
        let worst = pairs.iter().fold(1e-12_f32, |most, p| most.max(p.2));
        self.pair_records.decay_weights();
        for &(one, other, energy) in pairs.iter().filter(|_| self.prepared.components.weights) {
            let record = self.pair_records.pair_or_insert(one, other);
            // The factor is 2 for the worst pair and 1.2 for the least (the decay above is undone).
            record.weight = (record.weight / WEIGHT_DECAY * (1.2 + 0.8 * (energy / worst).sqrt())).min(MAX_WEIGHT);
        }
        energies.iter().sum()
    }

    /// Takes apart the layout that was just confirmed as `pieces`.
    pub(crate) fn take_apart(&mut self, pieces: &[PlacedItem]) -> DisassemblyPlan {
        plan_disassembly(self.prepared, pieces, &self.move_counts, &mut self.interlock_memory.disassembly)
    }

    /// Keeps the hulls of two parts apart because the parts were interlocked. Returns whether this is new.
    pub(crate) fn keep_hulls_apart(&mut self, one: usize, other: usize) -> bool {
        self.pair_records.pair_or_insert(one, other).known_overlap = None;
        self.interlock_memory.keep_apart(one, other)
    }

    /// Resets the weights, reduces the margins and forgets what is known of the walls.
    pub(crate) fn age_memory(&mut self) {
        self.pair_records.reset_weights();
        self.walls.fill(WallRecord::NONE);
        self.interlock_memory.age_pairs();
    }
}
