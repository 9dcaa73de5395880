//! The motion of all parts at once that keeps them apart: the smallest one after which no contact is too near, to first
//! order. Where one part after the other is pushed out of its overlaps, room at the bottom of a stack of parts reaches
//! the top only after many rounds. The contacts are solved one after the other, again and again, with pressures that
//! push and never pull (projected Gauss-Seidel, as in rigid-body simulation: Catto, Iterative Dynamics with Temporal
//! Coherence, 2005; for packing: Li and Milenkovic, Compaction and Separation Algorithms, 1995).

use glam::Vec3;

use super::separation_step::MAX_SPIN;

/// Change of a pressure below which the contacts are solved, mm.
const SOLVED_MM: f32 = 2e-3;
/// Greatest depth of a contact that one step is to end, mm. A deeper one is ended by several, so that parts that cannot be
/// separated here do not press their whole neighbourhood away.
const MAX_DEPTH_MM: f32 = 1.0;
/// Motion below which a part stays, mm: what rounding leaves of a pressure that came and went.
const STAYS_MM: f32 = 1e-4;

/// How a part can move.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PartMobility {
    /// 1 if it can be shifted, 0 if it is fixed.
    pub(crate) shift: f32,
    /// 1 for each axis about which it can rotate, otherwise 0.
    pub(crate) spin: Vec3,
    /// Distance from its center at which a rotation counts as much as a shift, mm.
    pub(crate) radius_mm: f32,
}

impl PartMobility {
    /// A part, or a wall, that does not move.
    pub(crate) const FIXED: Self = Self { shift: 0.0, spin: Vec3::ZERO, radius_mm: 1.0 };
}

/// The motion of a part.
#[derive(Debug, Clone, Copy, Default)]
struct PartMotion {
    /// Shift, mm.
    shift: Vec3,
    /// Rotation vector, radians x the part's radius: mm.
    spin: Vec3,
}

/// A contact: two parts must come no nearer along a direction.
#[derive(Debug, Clone)]
struct JointContact {
    parts: [usize; 2],
    /// Unit direction from the second part to the first.
    normal: Vec3,
    /// Motion of the contact along the normal per rotation of each part.
    levers: [Vec3; 2],
    /// Distance that is left, mm; negative where the parts are too near.
    gap_mm: f32,
    inverse_stiffness: f32,
    pressure: f32,
}

/// The contacts of all parts, and the motion that solves them.
#[derive(Debug)]
pub(crate) struct JointMotion {
    parts: Vec<PartMobility>,
    motions: Vec<PartMotion>,
    contacts: Vec<JointContact>,
}

impl JointMotion {
    /// Parts without contacts.
    pub(crate) fn new(parts: Vec<PartMobility>) -> Self {
        Self { motions: vec![PartMotion::default(); parts.len()], parts, contacts: Vec::new() }
    }

    /// Number of contacts.
    pub(crate) fn contact_count(&self) -> usize {
        self.contacts.len()
    }

    /// Adds a contact of two parts at points given from their centers. `normal` leads from the second to the first.
    pub(crate) fn add_contact(&mut self, parts: [usize; 2], arms: [Vec3; 2], normal: Vec3, gap_mm: f32) {
        let of = |side: usize| {
            let part = &self.parts[parts[side]];
            let lever = arms[side].cross(normal) / part.radius_mm;
            (lever, part.shift + (lever * part.spin).dot(lever))
        };
        let ((lever1, stiffness1), (lever2, stiffness2)) = (of(0), of(1));
        let stiffness = stiffness1 + stiffness2;
        if stiffness > 0.0 {
            let (levers, inverse_stiffness) = ([lever1, lever2], 1.0 / stiffness);
            let gap_mm = gap_mm.max(-MAX_DEPTH_MM);
            self.contacts.push(JointContact { parts, normal, levers, gap_mm, inverse_stiffness, pressure: 0.0 });
        }
    }

    /// Solves the contacts in at most `sweeps` sweeps. Returns the number of sweeps made.
    pub(crate) fn solve_contacts(&mut self, sweeps: usize) -> usize {
        for sweep in 1..=sweeps {
            let mut greatest = 0.0_f32;
            for contact in &mut self.contacts {
                let [one, other] = contact.parts;
                let moved = |side: usize, motion: &PartMotion| {
                    contact.normal.dot(motion.shift) + contact.levers[side].dot(motion.spin)
                };
                let gap_mm = contact.gap_mm + moved(0, &self.motions[one]) - moved(1, &self.motions[other]);
                let pressure = (contact.pressure - gap_mm * contact.inverse_stiffness).max(0.0);
                let change = pressure - contact.pressure;
                if change == 0.0 {
                    continue;
                }
                greatest = greatest.max(change.abs());
                contact.pressure = pressure;
                for (side, change) in [(0, change), (1, -change)] {
                    let (part, motion) = (&self.parts[contact.parts[side]], &mut self.motions[contact.parts[side]]);
                    motion.shift += contact.normal * (change * part.shift);
                    motion.spin += contact.levers[side] * part.spin * change;
                }
            }
            if greatest < SOLVED_MM {
                return sweep;
            }
        }
        sweeps
    }

    /// The motion of a part: shift in mm and rotation vector in radians; `None` if it stays. Neither its shift nor, at its
    /// radius, its rotation is more than `most_mm`.
    pub(crate) fn motion_of(&self, part: usize, most_mm: f32) -> Option<(Vec3, Vec3)> {
        let PartMotion { shift, spin } = self.motions[part];
        if shift.length_squared().max(spin.length_squared()) < STAYS_MM * STAYS_MM {
            return None;
        }
        let spin = spin.clamp_length_max(most_mm) / self.parts[part].radius_mm;
        Some((shift.clamp_length_max(most_mm), spin.clamp_length_max(MAX_SPIN)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FREE: PartMobility = PartMobility { shift: 1.0, spin: Vec3::ONE, radius_mm: 10.0 };

    /// A stack of parts on a floor (the last part, which is fixed), under a lid that presses by 1 mm; `gap_mm` below each.
    fn pressed_stack(parts: usize, gap_mm: f32) -> JointMotion {
        let mut joint = JointMotion::new([vec![FREE; parts], vec![PartMobility::FIXED]].concat());
        for part in 0..parts {
            let below = if part == 0 { parts } else { part - 1 };
            joint.add_contact([part, below], [Vec3::NEG_Z, Vec3::Z], Vec3::Z, gap_mm);
        }
        joint.add_contact([parts - 1, parts], [Vec3::Z, Vec3::ZERO], Vec3::NEG_Z, -1.0);
        joint
    }

    #[test]
    fn room_at_the_bottom_of_a_stack_reaches_its_top_at_once() {
        let mut joint = pressed_stack(8, 0.2);
        assert!(joint.solve_contacts(400) < 400);
        let downs: Vec<f32> = (0..8).map(|part| joint.motion_of(part, 9.0).map_or(0.0, |motion| -motion.0.z)).collect();
        assert!((downs[7] - 1.0).abs() < 0.02, "{downs:?}");
        assert!((0..7).all(|part| downs[part + 1] - downs[part] <= 0.2 + 0.02), "{downs:?}");
    }

    #[test]
    fn a_part_that_nothing_presses_stays() {
        let mut joint = JointMotion::new(vec![FREE, FREE, PartMobility::FIXED]);
        joint.add_contact([0, 2], [Vec3::NEG_Z, Vec3::ZERO], Vec3::Z, 0.1);
        joint.add_contact([1, 0], [Vec3::NEG_X, Vec3::X], Vec3::X, 0.0);
        assert_eq!(joint.solve_contacts(10), 1);
        assert!(joint.motion_of(0, 1.0).is_none() && joint.motion_of(1, 1.0).is_none());
    }

    #[test]
    fn what_cannot_rotate_is_shifted_and_nothing_moves_further_than_it_may() {
        let upright = PartMobility { spin: Vec3::Z, ..FREE };
        let mut joint = JointMotion::new(vec![upright, PartMobility::FIXED, PartMobility::FIXED]);
        joint.add_contact([1, 2], [Vec3::X, Vec3::X], Vec3::Z, -1.0);
        assert_eq!(joint.contact_count(), 0, "two fixed parts");
        joint.add_contact([0, 1], [Vec3::X * 10.0, Vec3::ZERO], Vec3::Z, -1.0);
        joint.solve_contacts(50);
        let (shift, spin) = joint.motion_of(0, 9.0).expect("it moves");
        assert!((shift - Vec3::Z).length() < 1e-3 && spin == Vec3::ZERO, "{shift} {spin}");
        assert!(joint.motion_of(0, 0.25).expect("it moves").0.length() < 0.2501);
        let mut tilting = JointMotion::new(vec![FREE, PartMobility::FIXED]);
        tilting.add_contact([0, 1], [Vec3::X * 10.0, Vec3::ZERO], Vec3::Z, -1.0);
        tilting.solve_contacts(50);
        let (shift, spin) = tilting.motion_of(0, 9.0).expect("it moves");
        assert!((shift.z + spin.cross(Vec3::X * 10.0).z - 1.0).abs() < 1e-2, "half is rotation: {shift} {spin}");
        assert!((shift.z - 0.5).abs() < 1e-2);
    }

    #[test]
    fn a_tiny_part_turns_no_further_than_a_step_can_see() {
        let tiny = PartMobility { radius_mm: 0.2, ..FREE };
        let mut joint = JointMotion::new(vec![tiny, PartMobility::FIXED]);
        joint.add_contact([0, 1], [Vec3::X * 0.3, Vec3::ZERO], Vec3::Z, -0.5);
        joint.solve_contacts(50);
        let (_, spin) = joint.motion_of(0, 0.5).expect("it moves");
        assert!((spin.length() - MAX_SPIN).abs() < 1e-3, "{spin}");
    }
}
