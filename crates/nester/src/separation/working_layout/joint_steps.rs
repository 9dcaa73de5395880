//! Steps of all parts of a working layout at once.

use glam::Vec3;

use super::{
    super::{
        exact_contacts,
        hull_penetration::smaller_radius,
        joint_motion::{JointMotion, PartMobility},
    },
    WorkingLayout,
};
use crate::OrientationRule;

/// Contacts that are further away than this are not seen by a step, mm. Neither the shift of a part nor its rotation, at
/// its radius, is more than half of it. Where a distance grid ends earlier, contacts are seen a little later.
const LOOK_AHEAD_MM: f32 = 1.0;
/// Parts are kept further apart than necessary by this, mm: a step that ends exactly at the limit never arrives.
const OVERSHOOT_MM: f32 = 0.02;
/// Greatest number of sweeps over all contacts.
const SWEEPS: usize = 40;
/// Greatest number of contacts of a pair.
const PAIR_CONTACTS: usize = 24;
/// Of contacts nearer to each other than this, relative to the smaller part's radius,
const NEIGHBOURHOOD: f32 = 0.25;
/// whose directions have at least this cosine, only the deepest counts.
const SAME_DIRECTION: f32 = 0.9;
/// Pairs looked at, parts moved, and contacts solved once, in the time of one evaluation.
const PER_EVALUATION: (usize, usize, usize) = (6, 8, 4000);

/// A place where two parts are near each other.
struct NearPlace {
    gap_mm: f32,
    /// The place from the center of each part, mm.
    arms: [Vec3; 2],
    /// Unit direction from the second part to the first.
    normal: Vec3,
}

impl WorkingLayout<'_> {
    /// Moves all parts at once, by the smallest motion after which, to first order, they keep their clearances and stand
    /// inside the walls and below the height limit. Nothing moves if this is so already.
    pub(crate) fn take_joint_step(&mut self) {
        let wall = self.part_count();
        let mobilities = (0..wall).map(|part| self.mobility(part)).chain([PartMobility::FIXED]);
        let mut joint = JointMotion::new(mobilities.collect());
        let clear = self.add_pair_contacts(&mut joint) <= OVERSHOOT_MM;
        let stands_out = |part| self.excess_mm(part, &self.proxies[part]) != Vec3::ZERO;
        if clear && !(0..self.parts.copy_count).any(stands_out) {
            return;
        }
        self.add_joint_walls(&mut joint, wall);
        let sweeps = joint.solve_contacts(SWEEPS);
        let mut moved = 0;
        for part in 0..self.parts.copy_count {
            if let Some((shift, spin)) = joint.motion_of(part, 0.5 * LOOK_AHEAD_MM) {
                self.move_part(part, self.displaced_pose(part, shift, spin));
                moved += 1;
            }
        }
        let solved = joint.contact_count() * sweeps;
        self.evaluations += (moved / PER_EVALUATION.1 + solved / PER_EVALUATION.2) as u64;
    }

    fn mobility(&self, part: usize) -> PartMobility {
        if self.parts.fixed[part] {
            return PartMobility::FIXED;
        }
        let spin = match self.motion_rule(part) {
            OrientationRule::Free => Vec3::ONE,
            OrientationRule::Upright => Vec3::Z,
            OrientationRule::Axis | OrientationRule::Fixed => Vec3::ZERO,
        };
        PartMobility { shift: 1.0, spin, radius_mm: self.motion_radius(part) }
    }

    /// Adds the contacts of all pairs. Returns how far the worst one falls short, mm.
    fn add_pair_contacts(&mut self, joint: &mut JointMotion) -> f32 {
        let pairs = self.nearby_pairs();
        self.evaluations += (pairs.len() / PER_EVALUATION.0 + 1) as u64;
        let (mut worst, mut places) = (0.0_f32, Vec::new());
        for (one, other) in pairs {
            self.find_near_places(one, other, &mut places);
            worst = places.iter().fold(worst, |worst, place| worst.max(-place.gap_mm));
            let radius_mm = smaller_radius(&self.proxies[one], &self.proxies[other]);
            keep_deepest(&mut places, NEIGHBOURHOOD * radius_mm);
            places.iter().for_each(|place| joint.add_contact([one, other], place.arms, place.normal, place.gap_mm));
        }
        worst
    }

    /// Finds where two parts are too near, or nearly so, by the proxies and by their exact contacts.
    fn find_near_places(&self, one: usize, other: usize, places: &mut Vec<NearPlace>) {
        places.clear();
        let (wanted, there) = (self.pair_constraint(one, other), &self.proxies[other]);
        let reach = wanted.reach + OVERSHOOT_MM;
        for &lift in &self.raise_offsets {
            let here = self.proxies[one].raised_by(lift);
            let apart = here.center - there.center;
            here.visit_near_points(there, reach + LOOK_AHEAD_MM, |near| {
                let arms = [near.arm, near.arm + apart];
                places.push(NearPlace { gap_mm: near.distance - reach, arms, normal: near.direction });
            });
        }
        let limit = wanted.clearance + OVERSHOOT_MM;
        let pair = (&self.proxies[one], there);
        for contact in exact_contacts::active_contacts(wanted.contacts, pair, limit + LOOK_AHEAD_MM) {
            let arms = [contact.point1 - pair.0.center, contact.point2 - there.center];
            places.push(NearPlace { gap_mm: LOOK_AHEAD_MM - contact.depth, arms, normal: contact.direction });
        }
    }

    /// Adds the contacts with floor, walls and height limit.
    fn add_joint_walls(&self, joint: &mut JointMotion, wall: usize) {
        let room = self.prepared.room.with_z(self.height_limit_mm).as_vec3();
        for (part, proxy) in self.proxies[..self.parts.copy_count].iter().enumerate() {
            let nearest = proxy.min.min(room - proxy.max).min_element();
            if self.parts.fixed[part] || nearest >= LOOK_AHEAD_MM {
                continue;
            }
            let excess = self.excess_mm(part, proxy);
            // What is too long for the room must become shorter than the room, not only as long.
            let spare = Vec3::select(excess.cmpgt(Vec3::ZERO), Vec3::splat(OVERSHOOT_MM), Vec3::ZERO);
            // The extremes may miss a little of what the bounds know.
            let (seen_min, seen_max) = proxy.extreme_bounds();
            let unseen_low = (proxy.center + seen_min - proxy.min).max(Vec3::ZERO);
            let unseen_high = (proxy.max - proxy.center - seen_max).max(Vec3::ZERO);
            for &extreme in &proxy.shape.extremes_f32 {
                let arm = proxy.rotation * extreme;
                let (low, high) = (proxy.center + arm - unseen_low, room - proxy.center - arm - unseen_high);
                for axis in 0..3 {
                    for (gap_mm, normal) in [(low[axis], Vec3::AXES[axis]), (high[axis], -Vec3::AXES[axis])] {
                        if gap_mm < LOOK_AHEAD_MM {
                            joint.add_contact([part, wall], [arm, Vec3::ZERO], normal, gap_mm - spare[axis]);
                        }
                    }
                }
            }
        }
    }
}

/// Keeps the deepest place of each neighbourhood.
fn keep_deepest(places: &mut Vec<NearPlace>, neighbourhood_mm: f32) {
    places.sort_by(|one, other| one.gap_mm.total_cmp(&other.gap_mm));
    let mut kept = 0;
    for at in 0..places.len() {
        let (first, place) = (&places[..kept], &places[at]);
        let is_same = |known: &NearPlace| {
            (known.arms[0] - place.arms[0]).length_squared() < neighbourhood_mm * neighbourhood_mm
                && known.normal.dot(place.normal) > SAME_DIRECTION
        };
        if !first.iter().any(is_same) {
            places.swap(kept, at);
            kept += 1;
            if kept == PAIR_CONTACTS {
                break;
            }
        }
    }
    places.truncate(kept);
}
