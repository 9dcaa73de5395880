//! Checks whether a part fits into the build volume at all. This is checked before a part may wait for a batch, so that
//! a refusal can give the reason.

use std::f64::consts::TAU;

use glam::{DMat3, DQuat, DVec3};
use rand::RngExt;
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};
use solids::{Bounds, Mesh, Pose};

use crate::{
    BuildVolume, OrientationLimits, OrientationRule,
    orientation::rotations::{self, axis_rotations},
};

/// Distance that a placement keeps from the walls, mm. It is slightly negative, within the proof's tolerance, so that a
/// part exactly as large as the volume fits. Build files hold every digit, so nothing is lost to rounding later.
pub(crate) const WALL_SPARE_MM: f64 = -4e-7;

/// A part that fits in no allowed orientation.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct FitFailure {
    /// Extents in its best allowed orientation (the one with the least excess over the volume), mm. Extents of the
    /// unrotated mesh where none is allowed.
    pub extents_mm: DVec3,
    /// Whether the orientation rules contradict each other: no rotation obeys all of them.
    pub is_forbidden: bool,
}

impl FitFailure {
    /// Why the part cannot be placed in a volume, without its name.
    pub fn reason(&self, volume: &BuildVolume) -> String {
        if self.is_forbidden {
            return "no rotation obeys all of its orientation rules".to_owned();
        }
        let (needs, has) = (self.extents_mm, volume.size_mm);
        format!(
            "needs {:.1} x {:.1} x {:.1} mm in its best allowed orientation, there are {} x {} x {} mm",
            needs.x, needs.y, needs.z, has.x, has.y, has.z
        )
    }
}

/// Returns an allowed rotation in which the mesh fits into the volume, or the extents of the best rotation.
///
/// ```
/// use glam::DVec3;
/// use nester::{BuildVolume, OrientationRule, find_fitting_rotation};
/// use solids::Mesh;
///
/// let rail = Mesh::cuboid(DVec3::new(320.0, 8.0, 8.0))?;
/// let cube = BuildVolume { size_mm: DVec3::splat(200.0) };
/// assert!(find_fitting_rotation(&rail, &OrientationRule::Free.into(), &cube).is_ok()); // along the diagonal
///
/// let misfit = find_fitting_rotation(&rail, &OrientationRule::Axis.into(), &cube).unwrap_err();
/// assert_eq!(
///     misfit.reason(&cube),
///     "needs 320.0 x 8.0 x 8.0 mm in its best allowed orientation, there are 200 x 200 x 200 mm"
/// );
/// # Ok::<(), solids::MeshError>(())
/// ```
pub fn find_fitting_rotation(
    mesh: &Mesh,
    orientation: &OrientationLimits,
    volume: &BuildVolume,
) -> Result<DQuat, FitFailure> {
    let probe = ExtentProbe {
        points: rotations::extreme_points(mesh.vertices(), 600),
        room: volume.size_mm - 2.0 * WALL_SPARE_MM,
    };
    let (mut best, mut least) = (DQuat::IDENTITY, f64::INFINITY);
    let rule = orientation.rule;
    let starts = match rule {
        OrientationRule::Fixed => vec![DQuat::IDENTITY],
        OrientationRule::Axis => axis_rotations().to_vec(),
        OrientationRule::Upright => (0..360).map(|d| DQuat::from_rotation_z(f64::from(d).to_radians())).collect(),
        OrientationRule::Free => free_start_rotations(&probe, orientation),
    };
    let allowed = starts.into_iter().filter_map(|turn| orientation.nearest_allowed(turn));
    let mut ranked: Vec<(f64, DQuat)> = allowed.map(|turn| (probe.excess_mm(turn), turn)).collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let refined = if matches!(rule, OrientationRule::Free | OrientationRule::Upright) { 12 } else { ranked.len() };
    for &(excess, start) in ranked.iter().take(refined) {
        let (excess, turn) = match rule {
            OrientationRule::Fixed | OrientationRule::Axis => (excess, start),
            _ if excess <= 0.0 => (excess, start),
            _ => reduce_excess(&probe, start, excess, orientation),
        };
        if excess <= 0.0 && fits_room(mesh, turn, probe.room) {
            return Ok(turn);
        }
        if excess < least {
            (best, least) = (turn, excess);
        }
    }
    Err(FitFailure { extents_mm: extents_at(mesh, best), is_forbidden: ranked.is_empty() })
}

/// Extents of a mesh at a rotation, mm.
fn extents_at(mesh: &Mesh, turn: DQuat) -> DVec3 {
    mesh.bounds_at(&Pose::new(turn, DVec3::ZERO)).size()
}

fn fits_room(mesh: &Mesh, turn: DQuat, room: DVec3) -> bool {
    extents_at(mesh, turn).cmple(room).all()
}

/// The points that determine a part's extents, and the available room.
struct ExtentProbe {
    points: Vec<DVec3>,
    room: DVec3,
}

impl ExtentProbe {
    /// Excess of the worst extent over the room, mm; negative when all extents are smaller.
    fn excess_mm(&self, turn: DQuat) -> f64 {
        let matrix = DMat3::from_quat(turn);
        let size = Bounds::from_points(self.points.iter().map(|&p| matrix * p)).size();
        (size - self.room).max_element()
    }
}

/// Start rotations: axes onto axes, the part's longest line onto the volume's diagonals, and random rotations.
fn free_start_rotations(probe: &ExtentProbe, orientation: &OrientationLimits) -> Vec<DQuat> {
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut starts = axis_rotations().to_vec();
    let frame = rotations::principal_frame(&probe.points);
    starts.extend(axis_rotations().iter().map(|&turn| turn * frame.conjugate()));
    let long = longest_line(&probe.points);
    for sign in [DVec3::ONE, DVec3::new(-1.0, 1.0, 1.0), DVec3::new(1.0, -1.0, 1.0), DVec3::new(1.0, 1.0, -1.0)] {
        let onto = DQuat::from_rotation_arc(long, (probe.room * sign).normalize());
        starts.extend((0..24).map(|roll| onto * DQuat::from_axis_angle(long, f64::from(roll) * TAU / 24.0)));
    }
    starts.extend((0..150).filter_map(|_| orientation.rotation_from_genes(rng.random())));
    starts
}

/// Direction of a nearly longest line between two points.
fn longest_line(points: &[DVec3]) -> DVec3 {
    let farthest = |from: DVec3| {
        points
            .iter()
            .copied()
            .max_by(|a, b| a.distance_squared(from).total_cmp(&b.distance_squared(from)))
            .unwrap_or(from)
    };
    let mut from = points.first().copied().unwrap_or(DVec3::ZERO);
    for _ in 0..4 {
        from = farthest(from);
    }
    (farthest(from) - from).normalize_or(DVec3::X)
}

/// Random search within the rules, with a step that widens on success and narrows on failure. The excess has kinks, at
/// which gradient methods stall.
fn reduce_excess(probe: &ExtentProbe, start: DQuat, excess: f64, orientation: &OrientationLimits) -> (f64, DQuat) {
    let about_z = orientation.rule == OrientationRule::Upright;
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (mut turn, mut least, mut step) = (start, excess, 0.2_f64);
    for _ in 0..400 {
        let axis = if about_z { DVec3::Z } else { rotations::random_direction(&mut rng) };
        let angle = if about_z { rng.random_range(-1.0..1.0) * step } else { step };
        let Some(tried) = orientation.nearest_allowed((DQuat::from_axis_angle(axis, angle) * turn).normalize()) else {
            continue;
        };
        let found = probe.excess_mm(tried);
        if found < least {
            (turn, least, step) = (tried, found, (step * 1.6).min(0.5));
            if least <= 0.0 {
                break;
            }
        } else {
            step = (step * 0.93).max(1e-6);
        }
    }
    let about_z_exactly = |turn: DQuat| DQuat::from_rotation_z(2.0 * turn.z.atan2(turn.w));
    (least, if about_z { about_z_exactly(turn) } else { turn })
}

/// The shift that brings bounds inside the walls, mm. Bounds that are too long stand out at the far end.
pub(crate) fn shift_inside(bounds: &Bounds, room: DVec3) -> DVec3 {
    let shift = (room - WALL_SPARE_MM - bounds.max).min(DVec3::ZERO);
    shift + (WALL_SPARE_MM - (bounds.min + shift)).max(DVec3::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{TiltLimit, tests::testing::block};

    const CUBE: BuildVolume = BuildVolume { size_mm: DVec3::splat(200.0) };

    #[test]
    fn a_long_rail_fits_only_along_the_diagonal() {
        let rail = block(DVec3::new(320.0, 8.0, 8.0));
        let turn = find_fitting_rotation(&rail, &OrientationRule::Free.into(), &CUBE).expect("fits tilted");
        assert!(extents_at(&rail, turn).max_element() <= 200.0);
        for rule in [OrientationRule::Upright, OrientationRule::Axis, OrientationRule::Fixed] {
            assert!(find_fitting_rotation(&rail, &rule.into(), &CUBE).is_err(), "{rule:?}");
        }
    }

    #[test]
    fn an_upright_plate_fits_turned_about_z() {
        let plate = block(DVec3::new(260.0, 4.0, 190.0));
        let turn = find_fitting_rotation(&plate, &OrientationRule::Upright.into(), &CUBE).expect("fits across");
        assert!((turn * DVec3::Z - DVec3::Z).length() < 1e-9);
        assert!(find_fitting_rotation(&plate, &OrientationRule::Axis.into(), &CUBE).is_err());
    }

    #[test]
    fn a_refusal_names_the_best_extents() {
        let slab = block(DVec3::new(30.0, 412.0, 90.0));
        let flat = BuildVolume { size_mm: DVec3::new(300.0, 100.0, 100.0) };
        let misfit = find_fitting_rotation(&slab, &OrientationRule::Axis.into(), &flat).expect_err("is too long");
        assert!((misfit.extents_mm.x - 412.0).abs() < 1e-9, "{misfit:?}");
        assert!(misfit.extents_mm.y <= 100.0 && misfit.extents_mm.z <= 100.0);
    }

    fn tilted(rule: OrientationRule, tilts: &[([f64; 3], f64)]) -> OrientationLimits {
        let tilts = tilts.iter().map(|&(d, within)| TiltLimit::new(d.into(), within).expect("is a tilt")).collect();
        OrientationLimits { rule, tilts }
    }

    #[test]
    fn a_cone_keeps_a_rail_from_lying_down() {
        let rail = block(DVec3::new(220.0, 8.0, 8.0));
        assert!(find_fitting_rotation(&rail, &OrientationRule::Free.into(), &CUBE).is_ok());
        let steep = tilted(OrientationRule::Free, &[([1.0, 0.0, 0.0], 20.0)]);
        let misfit = find_fitting_rotation(&rail, &steep, &CUBE).expect_err("stands too high");
        assert!(!misfit.is_forbidden && misfit.extents_mm.z > 200.0, "{misfit:?}");
        let leaning = tilted(OrientationRule::Free, &[([1.0, 0.0, 0.0], 40.0)]);
        let turn = find_fitting_rotation(&rail, &leaning, &CUBE).expect("leans");
        assert!(leaning.allows_rotation(turn));
    }

    #[test]
    fn rules_that_clash_are_reported_as_such() {
        let cube = block(DVec3::splat(10.0));
        for orientation in [
            tilted(OrientationRule::Free, &[([0.0, 0.0, 1.0], 40.0), ([0.0, 0.0, -1.0], 40.0)]),
            tilted(OrientationRule::Upright, &[([1.0, 0.0, 0.0], 80.0)]),
            tilted(OrientationRule::Axis, &[([1.0, 1.0, 0.0], 30.0)]),
            tilted(OrientationRule::Fixed, &[([0.0, 0.0, -1.0], 135.0)]),
        ] {
            let misfit = find_fitting_rotation(&cube, &orientation, &CUBE).expect_err("nothing is allowed");
            assert!(misfit.is_forbidden && misfit.reason(&CUBE).contains("no rotation"), "{orientation:?}");
        }
        assert!(
            find_fitting_rotation(&cube, &tilted(OrientationRule::Axis, &[([1.0, 1.0, 0.0], 50.0)]), &CUBE).is_ok()
        );
    }
}
