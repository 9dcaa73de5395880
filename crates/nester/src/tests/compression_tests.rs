//! Tests of a single descent.

use glam::{DQuat, DVec3};
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

use super::testing::{block, coarsely_prepared};
use crate::{
    BuildVolume, NestingInstance, NestingItem,
    prepare::prepared_instance::height_mm,
    search::compression::{CompressionBudget, CompressionRun},
};

/// Evaluations of a descent.
const EVALUATIONS: u64 = 6000;

#[test]
fn a_pace_of_endless_failures_only_makes_a_descent_try_hardest() {
    let volume = BuildVolume { size_mm: DVec3::splat(34.0) };
    let items = vec![NestingItem::new("block", block(DVec3::splat(10.0)), 1)];
    let instance = NestingInstance::new(volume, 1.0, items).expect("it can be nested");
    let prepared = coarsely_prepared(&instance);
    let lying = prepared.place_item((0, 0), DQuat::IDENTITY, DVec3::ZERO);
    let center = DVec3::new(17.0, 17.0, -lying.bounds.min.z);
    let start = [prepared.place_item((0, 0), DQuat::IDENTITY, center)];
    let mut descent = CompressionRun::new(&prepared, &start, ChaCha8Rng::seed_from_u64(1));
    descent.pace.failures = u64::MAX;
    let spent = |evaluations: u64| evaluations as f64 / EVALUATIONS as f64;
    descent.run(&CompressionBudget { spent_share_at: &spent, until: 1.0, lower_bound_mm: 0.0 }, &mut |_, _| {});
    assert_eq!((descent.pace.failures, descent.height_mm), (u64::MAX, height_mm(&start)));
}
