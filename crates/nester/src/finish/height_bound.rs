//! A lower bound of the build height that no layout can beat.

use std::{collections::BinaryHeap, sync::Arc};

use glam::DVec3;
use solids::{Bounds, Mesh};

use crate::{
    NestingInstance, OrientationLimits, OrientationRule, TiltLimit,
    orientation::{rotations::extreme_points, tilt::nearest_up},
};

/// The least width is found to within this share of the part's diameter. The bound stays below the true width.
const WIDTH_SHARE: f64 = 1e-3;
/// Number of directions in which the extreme points of a part are taken.
const EXTREME_DIRECTIONS: usize = 600;
/// Greatest number of directions tested per part; more would only sharpen the bound.
const MAX_DIRECTIONS: usize = 20_000;

/// A height that no layout with all copies of the instance can beat, mm: the part volume over the base area, or the
/// least height of the tallest item over its allowed rotations, whichever is greater. It is never above the true
/// minimum. 0 without copies.
///
/// ```
/// use std::sync::Arc;
/// use glam::DVec3;
/// use nester::{BuildVolume, NestingInstance, NestingItem, lower_bound_mm};
///
/// let cube = Arc::new(sample_parts::cuboid(DVec3::splat(10.0)));
/// let volume = BuildVolume { size_mm: DVec3::new(100.0, 50.0, 400.0) };
/// let instance = NestingInstance::new(volume, 1.0, vec![NestingItem::new("cube", cube, 500)])?;
/// assert!((lower_bound_mm(&instance) - 100.0).abs() < 1e-9); // 500 cm3 on 50 cm2
/// # Ok::<(), nester::InstanceError>(())
/// ```
pub fn lower_bound_mm(instance: &NestingInstance) -> f64 {
    let base = instance.volume().size_mm;
    let volume_mm3: f64 = instance.items().iter().map(|i| f64::from(i.copies) * i.mesh.volume_mm3()).sum();
    let mut known: Vec<(&Arc<Mesh>, &OrientationLimits)> = Vec::new();
    // No layer is filled beyond the base area or the area cap.
    let mut bound_mm = volume_mm3 / (base.x * base.y).min(instance.layer_cap().area_mm2);
    for item in instance.items().iter().filter(|i| i.copies > 0) {
        if known.iter().any(|(mesh, rule)| Arc::ptr_eq(mesh, &item.mesh) && **rule == item.orientation) {
            continue;
        }
        known.push((&item.mesh, &item.orientation));
        bound_mm = bound_mm.max(least_height_mm(&item.mesh, &item.orientation, bound_mm));
    }
    bound_mm
}

/// A lower bound of the height of a part over all allowed rotations, mm. A part whose extents show that it cannot raise
/// the bound is not examined further.
fn least_height_mm(mesh: &Arc<Mesh>, orientation: &OrientationLimits, bound_mm: f64) -> f64 {
    let size = mesh.bounds().size();
    match orientation.rule {
        OrientationRule::Upright | OrientationRule::Fixed => size.z,
        OrientationRule::Axis => {
            let lets = |axis: &DVec3| orientation.tilts.iter().all(|tilt| tilt.allows_up(*axis, 1e-6));
            let may_stand = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().filter(|axis| lets(axis) || lets(&-axis));
            // If the rules contradict each other, the part is never placed and gives no bound.
            may_stand.map(|axis| size.dot(axis)).min_by(f64::total_cmp).unwrap_or(0.0)
        }
        OrientationRule::Free if orientation.tilts.is_empty() && size.min_element() <= bound_mm => 0.0,
        OrientationRule::Free => {
            least_width_mm(&extreme_points(mesh.vertices(), EXTREME_DIRECTIONS), &orientation.tilts, bound_mm)
        }
    }
}

/// A triangular patch of directions, and a lower bound of the part's width over them.
struct DirectionPatch {
    least_mm: f64,
    corners: [DVec3; 3],
}

impl PartialEq for DirectionPatch {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for DirectionPatch {}

impl PartialOrd for DirectionPatch {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for DirectionPatch {
    /// The heap returns the greatest element first: the patch with the least width bound.
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        other.least_mm.total_cmp(&self.least_mm)
    }
}

/// A lower bound of the least distance of two parallel planes with the part between them, mm, close to the true value.
/// Branch and bound over the directions: the width is a norm of the direction, so between directions u and v it changes
/// by at most diameter x |u - v|. The width of some of the part's points is at most that of all points, so the bound
/// stays below the true value. Directions that the tilts do not allow to point straight up are left out. A part that
/// cannot raise `bound_mm` is not examined further.
fn least_width_mm(points: &[DVec3], tilts: &[TiltLimit], bound_mm: f64) -> f64 {
    let width = |d: DVec3| {
        let (low, high) = points
            .iter()
            .map(|p| p.dot(d))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        high - low
    };
    let diameter = Bounds::from_points(points.iter().copied()).size().length();
    let patch = |corners: [DVec3; 3], best: &mut f64| {
        let middle = (corners[0] + corners[1] + corners[2]).normalize();
        let found = width(middle);
        let reach = corners.iter().map(|c| c.distance(middle)).fold(0.0, f64::max);
        let lets = |spare: f64| [middle, -middle].iter().any(|&up| tilts.iter().all(|tilt| tilt.allows_up(up, spare)));
        if lets(0.0) {
            *best = best.min(found);
        }
        // An arc is at most pi / 2 times its chord.
        let least_mm = if lets(1.6 * reach) { found - diameter * reach } else { f64::INFINITY };
        DirectionPatch { least_mm, corners }
    };
    let sides = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|side| [side, -side]);
    let mut best = sides.filter_map(|side| nearest_up(tilts, side)).map(width).fold(f64::INFINITY, f64::min);
    if best <= bound_mm || best == f64::INFINITY {
        return 0.0;
    }
    // Four octants: a direction and its opposite have the same width.
    let octants = [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
    let mut patches: BinaryHeap<DirectionPatch> =
        octants.map(|(x, y)| patch([DVec3::X * x, DVec3::Y * y, DVec3::Z], &mut best)).into_iter().collect();
    for _ in 0..MAX_DIRECTIONS {
        let Some(worst) = patches.pop() else { break };
        if worst.least_mm >= best - WIDTH_SHARE * diameter {
            return worst.least_mm.clamp(0.0, best);
        }
        let [a, b, c] = worst.corners;
        let [ab, bc, ca] = [a + b, b + c, c + a].map(DVec3::normalize);
        for corners in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            let next = patch(corners, &mut best);
            patches.push(DirectionPatch { least_mm: next.least_mm.max(worst.least_mm), ..next });
        }
    }
    patches.pop().map_or(0.0, |worst| worst.least_mm.clamp(0.0, best))
}

#[cfg(test)]
mod tests {
    use glam::DQuat;
    use proptest::prelude::*;
    use sample_parts::fixtures::{block, star};

    use super::*;
    use crate::{BuildVolume, NestingItem};

    fn of(mesh: Arc<Mesh>, copies: u32, orientation: impl Into<OrientationLimits>) -> f64 {
        let item =
            NestingItem { name: "part".into(), mesh, copies, orientation: orientation.into(), clearance_mm: None };
        let volume = BuildVolume { size_mm: DVec3::new(100.0, 50.0, 400.0) };
        lower_bound_mm(&NestingInstance::new(volume, 1.0, vec![item]).unwrap())
    }

    fn turned(mesh: &Mesh, turn: DQuat) -> Arc<Mesh> {
        let vertices = mesh.vertices().iter().map(|&v| turn * v).collect();
        Arc::new(Mesh::new(vertices, mesh.triangles().to_vec()).unwrap())
    }

    #[test]
    fn a_brick_cannot_be_lower_than_its_rule_allows() {
        let brick = || block(30.0, 8.0, 20.0);
        assert_eq!(of(brick(), 1, OrientationRule::Fixed), 20.0);
        assert_eq!(of(brick(), 1, OrientationRule::Upright), 20.0);
        assert_eq!(of(brick(), 1, OrientationRule::Axis), 8.0);
        let free = of(brick(), 1, OrientationRule::Free);
        assert!((7.95..=8.0).contains(&free), "{free}");
        let skew = turned(&brick(), DQuat::from_rotation_y(0.6) * DQuat::from_rotation_x(1.1));
        let free = of(skew, 1, OrientationRule::Free);
        assert!((7.95..=8.0 + 1e-9).contains(&free), "{free}");
    }

    #[test]
    fn tilts_raise_the_bound() {
        let tilted = |rule, direction: DVec3, within| OrientationLimits {
            rule,
            tilts: vec![TiltLimit::new(direction, within).unwrap()],
        };
        let brick = || block(30.0, 8.0, 20.0);
        let upright = of(brick(), 1, tilted(OrientationRule::Free, DVec3::X, 0.0));
        assert!((29.9..=30.0 + 1e-9).contains(&upright), "{upright}");
        // Leaning by 30 degrees towards its 8 mm, it is 30 cos 30 + 8 sin 30 high.
        let leaning = of(brick(), 1, tilted(OrientationRule::Free, DVec3::X, 30.0));
        assert!((29.8..=29.99).contains(&leaning), "{leaning}");
        assert_eq!(of(brick(), 1, tilted(OrientationRule::Axis, DVec3::new(1.0, 0.0, 1.0), 50.0)), 20.0);
        let clash =
            OrientationLimits { rule: OrientationRule::Axis, tilts: vec![TiltLimit::new(DVec3::ONE, 10.0).unwrap()] };
        assert!(of(brick(), 1, clash) < 1.0);
    }

    #[test]
    fn many_copies_are_bounded_by_their_volume() {
        assert!((of(block(10.0, 10.0, 10.0), 500, OrientationRule::Free) - 100.0).abs() < 1e-9);
    }

    #[test]
    fn a_tetrahedron_is_widest_between_opposite_edges() {
        let corners = [(1.0, 1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0)];
        let vertices = corners.map(|(x, y, z)| DVec3::new(x, y, z)).to_vec();
        let mesh = Mesh::new(vertices, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).unwrap();
        let free = of(Arc::new(mesh), 1, OrientationRule::Free);
        assert!((1.98..=2.0).contains(&free), "{free}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        #[test]
        fn no_way_up_that_is_allowed_is_lower(within in 0.0..120.0f64, genes in [0.0..1.0f64, 0.0..1.0f64, 0.0..1.0f64]) {
            let mesh = star(2, |d| (DVec3::new(9.0, 5.0, 3.0) * d).length());
            let tilts = vec![TiltLimit::new(DVec3::new(1.0, 0.4, -0.2), within).unwrap()];
            let orientation = OrientationLimits { rule: OrientationRule::Free, tilts };
            let bound = of(mesh.clone(), 1, orientation.clone());
            let turn = orientation.rotation_from_genes(genes).unwrap();
            prop_assert!(turned(&mesh, turn).bounds().size().z >= bound - 1e-6);
        }

        #[test]
        fn no_direction_is_narrower(seed in 0.0..6.0f64, a in -3.2..3.2f64, b in -3.2..3.2f64) {
            let mesh = star(2, |d| (DVec3::new(9.0, 5.0, 3.0) * d).length() * (1.0 + 0.2 * (4.0 * d.y + seed).sin()));
            let bound = of(mesh.clone(), 1, OrientationRule::Free);
            let turned = turned(&mesh, DQuat::from_rotation_z(a) * DQuat::from_rotation_x(b));
            prop_assert!(turned.bounds().size().min_element() >= bound - 1e-9);
        }
    }
}
