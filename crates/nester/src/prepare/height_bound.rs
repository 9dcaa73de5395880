//! A lower bound of the build height that no layout can beat.

use std::{collections::BinaryHeap, sync::Arc};

use glam::DVec3;
use solids::{Bounds, ExtremePoints, Mesh};

use crate::{
    NestingInstance, NestingItem, OrientationLimits, OrientationRule, TiltLimit, orientation::tilt::nearest_up,
};

/// The least width is found to within this share of the part's diameter. The bound stays below the true width.
const WIDTH_SHARE: f64 = 1e-5;
/// Greatest number of patches of directions divided per part; more would only sharpen the bound.
const MAX_PATCHES: usize = 3000;

/// A height that no layout with all copies of the instance can beat, mm: the part volume over the base area, or the
/// least height of the tallest item over its allowed rotations, whichever is greater. It is never above the true
/// minimum. 0 without copies.
///
/// ```
/// use std::sync::Arc;
/// use glam::DVec3;
/// use nester::{BuildVolume, NestingInstance, NestingItem, lower_bound_mm};
/// use solids::Mesh;
///
/// let cube = Arc::new(Mesh::cuboid(DVec3::splat(10.0))?);
/// let volume = BuildVolume { size_mm: DVec3::new(100.0, 50.0, 400.0) };
/// let instance = NestingInstance::new(volume, 1.0, vec![NestingItem::new("cube", cube, 500)])?;
/// assert!((lower_bound_mm(&instance) - 100.0).abs() < 1e-9); // 500 cm3 on 50 cm2
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn lower_bound_mm(instance: &NestingInstance) -> f64 {
    let base = instance.volume().size_mm;
    let volume_mm3: f64 = instance.items().iter().map(|i| f64::from(i.copies) * i.mesh.volume_mm3()).sum();
    let mut known: Vec<(&Arc<Mesh>, &OrientationLimits)> = Vec::new();
    // No layer is filled beyond the base area or the area cap.
    let mut bound_mm = volume_mm3 / (base.x * base.y).min(instance.layer_cap().area_mm2);
    let mut items: Vec<&NestingItem> = instance.items().iter().filter(|i| i.copies > 0).collect();
    // The widest first: after it, others are soon known not to raise the bound.
    let extent = |item: &NestingItem| item.mesh.bounds().size().min_element();
    items.sort_by(|one, other| extent(other).total_cmp(&extent(one)));
    for item in items {
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
        OrientationRule::Free => least_width_mm(mesh.vertices(), &orientation.tilts, bound_mm),
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

/// A lower bound of the least distance of two parallel planes with the part between them, mm: the true value, to within
/// [`WIDTH_SHARE`] of the diameter, as long as [`MAX_PATCHES`] are enough. Branch and bound over the directions. Those
/// that the tilts do not allow to point straight up are left out. 0 = the part cannot raise `bound_mm`.
fn least_width_mm(vertices: &[DVec3], tilts: &[TiltLimit], bound_mm: f64) -> f64 {
    let part = WidthSearch { vertices, extreme: ExtremePoints::new(vertices), tilts };
    let precision_mm = WIDTH_SHARE * Bounds::from_points(vertices.iter().copied()).size().length();
    let sides = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|side| [side, -side]);
    let widths = sides.filter_map(|side| nearest_up(tilts, side)).map(|up| part.span(up).dot(up));
    let Some(mut best_mm) = widths.min_by(f64::total_cmp) else { return 0.0 };
    // Four octants: a direction and its opposite have the same width.
    let octants = [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
    let octants = octants.map(|(x, y)| part.patch([DVec3::X * x, DVec3::Y * y, DVec3::Z], &mut best_mm));
    let mut patches = BinaryHeap::from(octants);
    for divided in 0.. {
        if best_mm <= bound_mm {
            break;
        }
        let Some(worst) = patches.pop() else { break };
        if worst.least_mm >= best_mm - precision_mm || divided >= MAX_PATCHES {
            return worst.least_mm.clamp(0.0, best_mm);
        }
        let [a, b, c] = worst.corners;
        let [ab, bc, ca] = [a + b, b + c, c + a].map(DVec3::normalize);
        for corners in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            let next = part.patch(corners, &mut best_mm);
            patches.push(DirectionPatch { least_mm: next.least_mm.max(worst.least_mm), ..next });
        }
    }
    0.0
}

/// A part whose narrowest direction is searched.
struct WidthSearch<'a> {
    vertices: &'a [DVec3],
    extreme: ExtremePoints<'a>,
    tilts: &'a [TiltLimit],
}

impl WidthSearch<'_> {
    /// The way from the point that reaches farthest against a direction to the one that reaches farthest along it.
    fn span(&self, direction: DVec3) -> DVec3 {
        let farthest = |direction: DVec3| self.vertices[self.extreme.farthest_point(direction)];
        farthest(direction) - farthest(-direction)
    }

    /// A patch with its bound: the part is at least as wide as the distance of any two of its points along a direction.
    /// A direction of the patch is a weighted mean of the corners, lengthened to 1, so the two points that are farthest
    /// apart along the middle are nowhere nearer than along one of the corners.
    fn patch(&self, corners: [DVec3; 3], best_mm: &mut f64) -> DirectionPatch {
        let middle = (corners[0] + corners[1] + corners[2]).normalize();
        let (span, reach) = (self.span(middle), corners.iter().map(|c| c.distance(middle)).fold(0.0, f64::max));
        let lets =
            |spare: f64| [middle, -middle].iter().any(|&up| self.tilts.iter().all(|tilt| tilt.allows_up(up, spare)));
        if lets(0.0) {
            *best_mm = best_mm.min(span.dot(middle));
        }
        // An arc is at most pi / 2 times its chord.
        let least_mm = match lets(1.6 * reach) {
            true => corners.iter().map(|&corner| span.dot(corner)).fold(f64::INFINITY, f64::min).max(0.0),
            false => f64::INFINITY,
        };
        DirectionPatch { least_mm, corners }
    }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;
    use proptest::prelude::*;
    use sample_parts::fixtures::{block, star};

    use super::*;
    use crate::BuildVolume;

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
        assert!((7.999..=8.0).contains(&free), "{free}");
        let skew = turned(&brick(), DQuat::from_rotation_y(0.6) * DQuat::from_rotation_x(1.1));
        let free = of(skew, 1, OrientationRule::Free);
        assert!((7.999..=8.0 + 1e-9).contains(&free), "{free}");
    }

    #[test]
    fn tilts_raise_the_bound() {
        let tilted = |rule, direction: DVec3, within| OrientationLimits {
            rule,
            tilts: vec![TiltLimit::new(direction, within).unwrap()],
        };
        let brick = || block(30.0, 8.0, 20.0);
        let upright = of(brick(), 1, tilted(OrientationRule::Free, DVec3::X, 0.0));
        assert!((29.999..=30.0 + 1e-9).contains(&upright), "{upright}");
        // Leaning by 30 degrees towards its 8 mm, it is 30 cos 30 + 8 sin 30 high.
        let leaning = of(brick(), 1, tilted(OrientationRule::Free, DVec3::X, 30.0));
        let exact = 30.0 * 30f64.to_radians().cos() + 8.0 * 30f64.to_radians().sin();
        assert!((exact - 0.01..=exact + 1e-9).contains(&leaning), "{leaning} of {exact}");
        assert_eq!(of(brick(), 1, tilted(OrientationRule::Axis, DVec3::new(1.0, 0.0, 1.0), 50.0)), 20.0);
        let clash =
            OrientationLimits { rule: OrientationRule::Axis, tilts: vec![TiltLimit::new(DVec3::ONE, 10.0).unwrap()] };
        assert!(of(brick(), 1, clash) < 1.0);
    }

    #[test]
    fn many_copies_are_bounded_by_their_volume() {
        assert!((of(block(10.0, 10.0, 10.0), 500, OrientationRule::Free) - 100.0).abs() < 1e-9);
    }

    /// The exact least width of few points: it is that across a face, or between two edges.
    fn width_by_trial(points: &[DVec3]) -> f64 {
        let count = points.len();
        let edges: Vec<DVec3> =
            (0..count).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| points[i] - points[j]).collect();
        let across = edges.iter().enumerate().flat_map(|(at, one)| edges[..at].iter().map(|other| one.cross(*other)));
        let normals = across.filter(|normal| normal.length() > 1e-9).map(DVec3::normalize);
        normals.map(|d| width(points, d)).fold(f64::INFINITY, f64::min)
    }

    fn width(points: &[DVec3], direction: DVec3) -> f64 {
        let along = points.iter().map(|point| point.dot(direction));
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        high - low
    }

    fn turned_points(points: &[DVec3], turn: DQuat) -> Vec<DVec3> {
        points.iter().map(|&point| turn * point).collect()
    }

    #[test]
    fn known_solids_have_their_widths_however_they_lie() {
        let signs = [1.0, -1.0];
        let cube: Vec<DVec3> = signs
            .iter()
            .flat_map(|&x| signs.map(|y| (x, y)))
            .flat_map(|(x, y)| signs.map(|z| DVec3::new(x, y, z)))
            .collect();
        let tetrahedron: Vec<DVec3> = cube.iter().copied().filter(|c| c.x * c.y * c.z > 0.0).collect();
        let octahedron: Vec<DVec3> = DVec3::AXES.iter().flat_map(|&axis| [axis, -axis]).collect();
        let golden = f64::midpoint(1.0, 5f64.sqrt());
        let around = |a: f64, b: f64| [DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)];
        let icosahedron: Vec<DVec3> =
            signs.iter().flat_map(|&a| signs.map(|b| around(a, golden * b))).flatten().collect();
        let rectangles = signs.iter().flat_map(|&a| signs.map(|b| around(a / golden, golden * b))).flatten();
        let dodecahedron: Vec<DVec3> = cube.iter().copied().chain(rectangles).collect();
        let rod: Vec<DVec3> = cube.iter().map(|c| *c * DVec3::new(300.0, 2.0, 3.0)).collect();
        let solids = [
            (cube, 2.0),
            (tetrahedron, 2.0),
            (octahedron, 2.0 / 3f64.sqrt()),
            (icosahedron, 2.0 * golden.powi(2) / 3f64.sqrt()),
            (dodecahedron, 2.0 * golden.powi(2) / (golden.powi(2) + 1.0).sqrt()),
            (rod, 4.0),
        ];
        for (points, expected) in solids {
            assert!((width_by_trial(&points) - expected).abs() < 1e-9, "{expected}");
            let diameter = Bounds::from_points(points.iter().copied()).size().length();
            for turn in [DQuat::IDENTITY, DQuat::from_rotation_y(0.6) * DQuat::from_rotation_x(1.1)] {
                let found = least_width_mm(&turned_points(&points, turn), &[], 0.0);
                assert!((-4e-5 * diameter..=1e-9).contains(&(found - expected)), "{found} of {expected}");
            }
        }
    }

    #[test]
    fn a_smooth_part_takes_no_more_than_the_patches_that_it_may() {
        let ball = star(5, |d| 10.0 + 0.001 * (7.0 * d.x).sin());
        let found = of(ball.clone(), 1, OrientationRule::Free);
        let least = crate::orientation::rotations::spread_directions(2000).map(|d| width(ball.vertices(), d));
        let least = least.fold(f64::INFINITY, f64::min);
        assert!((least - 0.02..=least).contains(&found), "{found} of {least}");
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
        fn random_points_have_their_exact_width(
            places in prop::collection::vec([-9.0..9.0f64, -5.0..5.0f64, -3.0..3.0f64], 4..10),
            (a, b) in (-3.2..3.2f64, -3.2..3.2f64),
            below in 0.0..12.0f64,
        ) {
            let turn = DQuat::from_rotation_z(a) * DQuat::from_rotation_x(b);
            let points = turned_points(&places.into_iter().map(DVec3::from).collect::<Vec<_>>(), turn);
            let (exact, found) = (width_by_trial(&points), least_width_mm(&points, &[], 0.0));
            prop_assert!((exact - 1e-3..=exact + 1e-9).contains(&found), "{} of {}", found, exact);
            // A bound that is known from elsewhere only ends the search sooner.
            let raised = least_width_mm(&points, &[], below);
            prop_assert!(raised <= exact + 1e-9 && (exact < below + 1e-3 || raised >= exact - 1e-3), "{}", raised);
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
