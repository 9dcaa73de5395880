//! Random builds of the project's own parts: random parts, copies, volumes, clearances and orientation rules, a short
//! search each, and no check may find a fault. Builds of other people's parts are in `tests/data`.

use std::{collections::BTreeSet, sync::Arc};

use glam::DVec3;
use nester::{
    BuildVolume, FaceNotDown, NestingConfig, NestingInstance, NestingItem, NestingSolution, OrientationLimits,
    OrientationRule, PlacedSolid, SearchComponents, StopCondition, TiltLimit, nest, obeys_orientation,
    prove_placed_solids,
};
use parry3d_f64::{math::Pose3, query, shape::TriMesh};
use rand::{RngExt, SeedableRng, seq::IndexedRandom};
use rand_chacha::ChaCha8Rng;
use sample_parts::random_part;

use crate::support::random::{any_clearance_mm, any_tilt};

/// Number of builds of the project's own parts.
const OWN_BUILDS: u64 = 24;
struct EvaluationLimit(u64);

impl StopCondition for EvaluationLimit {
    fn spent_share_at(&self, evaluations: u64) -> f64 {
        evaluations as f64 / self.0 as f64
    }
}

fn any_orientation(rng: &mut ChaCha8Rng) -> OrientationLimits {
    use OrientationRule::{Axis, Fixed, Free, Upright};
    let rule = *[Free, Free, Upright, Axis, Fixed].choose(rng).unwrap();
    let keep_up: Option<TiltLimit> = rng.random_bool(0.2).then(|| any_tilt(rng, 20..120).parse().unwrap());
    let not_down: Option<FaceNotDown> = rng.random_bool(0.2).then(|| any_tilt(rng, 10..70).parse().unwrap());
    OrientationLimits::new(rule, keep_up.as_slice(), not_down.as_slice())
}

fn any_own_instance(rng: &mut ChaCha8Rng) -> NestingInstance {
    let items: Vec<NestingItem> = (0..rng.random_range(1..5))
        .map(|at| NestingItem {
            name: format!("part {at}"),
            mesh: Arc::new(random_part(rng.random_range(0..400))),
            copies: rng.random_range(1..6),
            orientation: any_orientation(rng),
            clearance_mm: rng.random_bool(0.2).then(|| any_clearance_mm(rng)),
        })
        .collect();
    let largest = items.iter().fold(DVec3::ZERO, |most, item| most.max(item.mesh.bounds().size()));
    let mut stretch = || rng.random_range(1.02..2.5);
    let size_mm = largest * DVec3::new(stretch(), stretch(), 2.0 * stretch());
    NestingInstance::new(BuildVolume { size_mm }, any_clearance_mm(rng), items).unwrap()
}

/// The distance of two placed meshes by another kernel, mm.
fn other_distance(one: &PlacedSolid, two: &PlacedSolid) -> f64 {
    let shape =
        |body: &PlacedSolid| TriMesh::new(body.mesh.vertices().to_vec(), body.mesh.triangles().to_vec()).unwrap();
    let pose = |body: &PlacedSolid| Pose3::from_parts(body.pose.translation, body.pose.rotation);
    query::distance(&pose(one), &shape(one), &pose(two), &shape(two)).unwrap().distance
}

fn assert_holds_what_was_asked(name: &str, instance: &NestingInstance, solution: &NestingSolution) {
    let bodies: Vec<PlacedSolid> = (solution.placements.iter())
        .map(|p| PlacedSolid {
            name: format!("{} #{}", p.item, p.copy),
            mesh: instance.items()[p.item].mesh.clone(),
            pose: p.pose,
            clearance_mm: instance.clearance_between_mm(p.item, p.item),
        })
        .collect();
    let proof = prove_placed_solids(&bodies, instance.volume().size_mm);
    assert!(proof.is_proved(), "{name}: {proof:?}");
    for p in &solution.placements {
        assert!(obeys_orientation(&instance.items()[p.item].orientation, &p.pose), "{name}: {p:?} against its rule");
        let bounds = instance.items()[p.item].mesh.bounds_at(&p.pose);
        let inside = bounds.min.min_element() > -1e-6 && (bounds.max - instance.volume().size_mm).max_element() < 1e-6;
        assert!(inside && bounds.max.z <= solution.height_mm + 1e-9, "{name}: {p:?} stands at {bounds:?}");
    }
    for (at, one) in bodies.iter().enumerate() {
        for two in &bodies[..at] {
            let wanted_mm = one.clearance_mm.max(two.clearance_mm);
            if one.mesh.bounds_at(&one.pose).distance(&two.mesh.bounds_at(&two.pose)) < wanted_mm {
                let distance_mm = other_distance(one, two);
                assert!(distance_mm > wanted_mm - 1e-6, "{name}: {} and {}: {distance_mm} mm", one.name, two.name);
            }
        }
    }
    let placed = solution.placements.iter().map(|p| (p.item, p.copy));
    let all_copies: Vec<(usize, u32)> = placed.chain(solution.unplaced.iter().copied()).collect();
    let once: BTreeSet<(usize, u32)> = all_copies.iter().copied().collect();
    assert!(once.len() == all_copies.len() && once.len() == instance.copy_count(), "{name}: a copy is lost or doubled");
}

#[test]
fn random_builds_of_our_own_parts_hold_what_was_asked() {
    let mut placed = 0;
    for number in 0..OWN_BUILDS {
        let mut rng = ChaCha8Rng::seed_from_u64(number);
        let instance = any_own_instance(&mut rng);
        // Fine guides would take most of the time of such a short search.
        let components = SearchComponents { fine_proxies: number % 6 == 0, ..SearchComponents::default() };
        let config = NestingConfig { seed: number, components, ..NestingConfig::default() };
        let mut tell = |_: &NestingSolution, _: u64| {};
        let solution = nest(&instance, &config, &[], &EvaluationLimit(rng.random_range(200..3000)), &mut tell);
        assert_holds_what_was_asked(&format!("build {number}"), &instance, &solution);
        placed += solution.placements.len();
    }
    assert!(placed > 100, "only {placed} placements are no test");
}
