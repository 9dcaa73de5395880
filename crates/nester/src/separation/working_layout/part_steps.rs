//! Steps of one part of a working layout.

use glam::{DQuat, Vec3};

use super::{
    super::{exact_contacts, separation_step::SeparationStep},
    CenterPose, WorkingLayout,
};
use crate::OrientationRule;

/// Parts are pushed further apart than necessary by this, mm: a step that ends exactly at the limit never arrives.
const OVERSHOOT_MM: f32 = 0.03;
/// The same for exact contacts.
const CONTACT_OVERSHOOT_MM: f32 = 0.004;

impl WorkingLayout<'_> {
    /// Takes one Gauss-Newton step that moves a part out of all its overlaps. Returns the weighted overlap before the
    /// step.
    pub(crate) fn take_separation_step(&mut self, part: usize) -> f32 {
        self.evaluations += 1;
        let proxy = &self.proxies[part];
        let mut push = SeparationStep::new(self.motion_radius(part));
        for other in self.nearby_parts(part, proxy) {
            let (wanted, there) = (self.pair_constraint(part, other), &self.proxies[other]);
            match self.raise_offsets[..] {
                [_] => proxy.add_overlap_contacts(there, wanted.reach + OVERSHOOT_MM, wanted.weight, &mut push),
                _ => self.raise_offsets.iter().for_each(|&lift| {
                    proxy.raised_by(lift).add_overlap_contacts(
                        there,
                        wanted.reach + OVERSHOOT_MM,
                        wanted.weight,
                        &mut push,
                    );
                }),
            }
            let pair = if part < other { (proxy, there) } else { (there, proxy) };
            let aim = (wanted.clearance + CONTACT_OVERSHOOT_MM, wanted.weight);
            exact_contacts::add_contacts(wanted.contacts, pair, part < other, aim, &mut push);
            self.interlock_memory.add_hull_contact((part, proxy), (other, there), wanted.weight, &mut push);
        }
        let rule = self.motion_rule(part);
        let energy = push.energy + self.weighted_excess(part, proxy);
        if energy <= 0.0 {
            return 0.0;
        }
        let (mut step, mut spin) = push.solve_motion(rule);
        if self.add_wall_contacts(part, step, spin, &mut push) {
            (step, spin) = push.solve_motion(rule);
        }
        self.move_part(part, self.displaced_pose(part, step, spin));
        energy
    }

    /// The pose of a part after a shift, mm, and a rotation, radians, as far as its rule allows it.
    pub(super) fn displaced_pose(&self, part: usize, shift: Vec3, spin: Vec3) -> CenterPose {
        let pose = self.poses[part];
        let rotation = match self.motion_rule(part) {
            OrientationRule::Free => {
                let spun = (DQuat::from_scaled_axis(spin.as_dvec3()) * pose.rotation).normalize();
                let orientation = &self.prepared.prepared_item(self.parts.copies[part].0).orientation;
                orientation.nearest_allowed(spun).unwrap_or(pose.rotation)
            }
            OrientationRule::Upright => (DQuat::from_rotation_z(f64::from(spin.z)) * pose.rotation).normalize(),
            OrientationRule::Axis | OrientationRule::Fixed => pose.rotation,
        };
        CenterPose { rotation, center: pose.center + shift.as_dvec3() }
    }

    /// The rule for the rotation of a part while it is pushed.
    pub(super) fn motion_rule(&self, part: usize) -> OrientationRule {
        if self.prepared.components.turning { self.orientation_rule(part) } else { OrientationRule::Fixed }
    }

    /// Distance from a part's center at which its rotation counts as much as a shift, mm.
    pub(super) fn motion_radius(&self, part: usize) -> f32 {
        0.7 * self.proxies[part].shape.radius_mm as f32
    }

    /// Adds contacts for the extreme points that a motion would carry through a wall. Returns whether any were added.
    fn add_wall_contacts(&self, part: usize, step: Vec3, spin: Vec3, push: &mut SeparationStep) -> bool {
        let proxy = &self.proxies[part];
        let room = self.prepared.room.with_z(self.height_limit_mm).as_vec3();
        let weight = 0.02 * push.energy.max(1.0) + 0.2 * proxy.shape.radius_mm as f32;
        let mut is_outside = false;
        for &extreme in &proxy.shape.extremes_f32 {
            let arm = proxy.rotation * extreme;
            let here = proxy.center + arm;
            let there = here + step + spin.cross(arm);
            for axis in 0..3 {
                let unit = Vec3::AXES[axis];
                if there[axis] < -1e-3 {
                    push.add_contact(arm, unit, (-here[axis]).min(1.0), weight);
                    is_outside = true;
                } else if there[axis] > room[axis] + 1e-3 {
                    push.add_contact(arm, -unit, (here[axis] - room[axis]).min(1.0), weight);
                    is_outside = true;
                }
            }
        }
        is_outside
    }
}
