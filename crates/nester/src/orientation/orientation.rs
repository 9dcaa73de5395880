//! All orientation limits of a part: the rule and the tilts. A hard constraint during the whole search.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

use super::{
    rotations,
    tilt::{RIM_TOLERANCE, nearest_up},
};
use crate::{FaceNotDown, OrientationRule, TiltLimit};

/// Orientation limits of a part: a rule, and directions of the mesh that must all stay near straight up.
///
/// ```
/// use glam::DVec3;
/// use nester::{FaceNotDown, OrientationLimits, OrientationRule, TiltLimit};
///
/// // About z only.
/// let upright = OrientationLimits::from(OrientationRule::Upright);
/// // In any way that keeps the mesh's x within 30 degrees of up, and its face towards +y from looking down.
/// let leaning = TiltLimit::new(DVec3::X, 30.0)?;
/// let face = FaceNotDown::new(DVec3::Y, 45.0)?;
/// let tilted = OrientationLimits::new(OrientationRule::Free, &[leaning], &[face]);
/// assert_eq!((upright.tilts.len(), tilted.tilts.len()), (0, 2));
/// # Ok::<(), nester::TiltLimitError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OrientationLimits {
    /// The allowed rotations.
    pub rule: OrientationRule,
    /// The limits on the up direction.
    pub tilts: Vec<TiltLimit>,
}

impl From<OrientationRule> for OrientationLimits {
    fn from(rule: OrientationRule) -> Self {
        Self { rule, tilts: Vec::new() }
    }
}

impl OrientationLimits {
    /// Combines a rule, directions that must stay up, and faces that must not look down.
    pub fn new(rule: OrientationRule, keep_up: &[TiltLimit], not_down: &[FaceNotDown]) -> Self {
        Self { rule, tilts: keep_up.iter().copied().chain(not_down.iter().map(|&face| face.into())).collect() }
    }

    /// Whether the tilts allow a rotation; the rule is not checked.
    pub(crate) fn allows_rotation(&self, turn: DQuat) -> bool {
        let up = turn.conjugate() * DVec3::Z;
        self.tilts.iter().all(|tilt| tilt.allows_up(up, RIM_TOLERANCE))
    }

    /// The rotation nearest to `turn` that the tilts allow, for a `turn` that obeys the rule. `None` if the rule leaves
    /// no freedom to reach it, or if no up direction obeys all tilts.
    pub(crate) fn nearest_allowed(&self, turn: DQuat) -> Option<DQuat> {
        if self.tilts.is_empty() || self.allows_rotation(turn) {
            return Some(turn);
        }
        if self.rule != OrientationRule::Free {
            return None;
        }
        let up = nearest_up(&self.tilts, turn.conjugate() * DVec3::Z)?;
        let brought = (DQuat::from_rotation_arc((turn * up).normalize(), DVec3::Z) * turn).normalize();
        self.allows_rotation(brought).then_some(brought)
    }

    /// Decodes a rotation from three numbers in 0..1 for a free rule. Uniform numbers give rotations that are uniform
    /// over what the tightest tilt allows; they are then moved to what the other tilts allow.
    pub(crate) fn rotation_from_genes(&self, genes: [f64; 3]) -> Option<DQuat> {
        let Some(tightest) = self.tilts.iter().min_by(|a, b| a.within_deg().total_cmp(&b.within_deg())) else {
            return Some(rotations::rotation_from_genes(genes));
        };
        let [share, around, roll] = genes;
        // Uniform over a spherical cap: the heights above its base are uniform.
        let cos = 1.0 - share * (1.0 - tightest.within_deg().to_radians().cos());
        let (sin, cos) = ((1.0 - cos * cos).max(0.0).sqrt(), cos);
        let axis = tightest.direction();
        let side = axis.any_orthonormal_vector();
        let (along_side, along_other) = (around * TAU).sin_cos();
        let up = (axis * cos + (side * along_side + axis.cross(side) * along_other) * sin).normalize();
        let up = nearest_up(&self.tilts, up)?;
        let turn = DQuat::from_rotation_z(roll * TAU) * DQuat::from_rotation_arc(up, DVec3::Z);
        self.nearest_allowed(turn.normalize())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::orientation::tilt::angle_between;

    proptest! {
        #[test]
        fn genes_give_rotations_that_obey(
            (x, y, z, within) in (-1.0..1.0_f64, -1.0..1.0_f64, 0.1..1.0_f64, 0.0..180.0_f64),
            genes in [0.0..1.0_f64, 0.0..1.0_f64, 0.0..1.0_f64],
        ) {
            let tilt = TiltLimit::new(DVec3::new(x, y, z), within).unwrap();
            let face = TiltLimit::new(DVec3::NEG_Z, 150.0).unwrap();
            let orientation = OrientationLimits { rule: OrientationRule::Free, tilts: vec![tilt, face] };
            if let Some(turn) = orientation.rotation_from_genes(genes) {
                prop_assert!(angle_between(turn * tilt.direction(), DVec3::Z) <= within.to_radians() + 2.0 * RIM_TOLERANCE);
                prop_assert!((turn * DVec3::NEG_Z).z >= 150_f64.to_radians().cos() - 1e-6);
            }
        }

        #[test]
        fn the_way_back_is_the_least_turn(genes in [0.0..1.0_f64, 0.0..1.0_f64, 0.0..1.0_f64], within in 0.0..180.0_f64) {
            let tilt = TiltLimit::new(DVec3::new(0.3, -0.2, 0.9), within).unwrap();
            let orientation = OrientationLimits { rule: OrientationRule::Free, tilts: vec![tilt] };
            let turn = rotations::rotation_from_genes(genes);
            let brought = orientation.nearest_allowed(turn).unwrap();
            let excess = (angle_between(turn * tilt.direction(), DVec3::Z) - within.to_radians()).max(0.0);
            prop_assert!((turn.angle_between(brought) - excess).abs() < 1e-5);
        }
    }
}
