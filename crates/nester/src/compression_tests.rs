//! Tests of a single descent: what it goes on from, and what it returns.

use glam::{DQuat, DVec3};
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

use super::{
    BuildVolume, NestingInstance, NestingItem,
    compression::{CompressionBudget, CompressionRun, swap_similar_parts},
    prepared_instance::{PlacedItem, PreparedInstance, height_mm},
    testing::{block, coarsely_prepared},
    working_layout::WorkingLayout,
};

const CLEARANCE_MM: f64 = 1.0;
/// Evaluations of a descent.
const EVALUATIONS: u64 = 6000;

/// Copies of blocks of the given sizes, in a room for a tower of all of them.
fn blocks(sizes: &[DVec3], copies: u32) -> NestingInstance {
    let items = sizes.iter().map(|&size| NestingItem::new("block", block(size), copies)).collect();
    let volume = BuildVolume { size_mm: DVec3::new(34.0, 34.0, 400.0) };
    NestingInstance::new(volume, CLEARANCE_MM, items).expect("it can be nested")
}

/// All copies in one tower that stands clear of the floor.
fn tower(prepared: &PreparedInstance) -> Vec<PlacedItem> {
    let mut top_mm = CLEARANCE_MM;
    let mut place = |&copy: &(usize, u32)| {
        let lying = prepared.place_item(copy, DQuat::IDENTITY, DVec3::ZERO);
        let center = DVec3::new(17.0, 17.0, top_mm - lying.bounds.min.z);
        top_mm += lying.bounds.size().z + 1.1 * CLEARANCE_MM;
        prepared.place_item(copy, DQuat::IDENTITY, center)
    };
    prepared.copies.iter().map(&mut place).collect()
}

#[test]
fn a_descent_goes_on_from_layouts_that_are_hardly_higher_and_returns_the_lowest() {
    let instance = blocks(&[DVec3::new(24.0, 11.0, 7.0), DVec3::new(15.0, 9.0, 12.0), DVec3::splat(10.0)], 3);
    let prepared = coarsely_prepared(&instance);
    let start = tower(&prepared);
    let mut travelled = 0;
    for seed in 0..3 {
        let mut descent = CompressionRun::new(&prepared, &start, ChaCha8Rng::seed_from_u64(seed));
        let mut heights = vec![height_mm(&start)];
        // It pauses often, to be looked at.
        for pause in 1..=50 {
            let spent = |evaluations: u64| evaluations as f64 / EVALUATIONS as f64;
            let budget =
                CompressionBudget { spent_share_at: &spent, until: f64::from(pause) / 50.0, lower_bound_mm: 0.0 };
            descent.run(&budget, &mut |pieces, _| heights.push(height_mm(pieces)));
            assert_eq!(descent.height_mm, height_mm(&descent.items));
            assert_eq!(Some(&descent.height_mm), heights.last());
            let above = descent.here_mm / descent.height_mm;
            assert!((1.0..1.01 + 1e-9).contains(&above), "seed {seed}, pause {pause}: {above} times as high");
            travelled += usize::from(above > 1.0);
        }
        assert!(heights.is_sorted_by(|before, after| after < before), "seed {seed}: {heights:?}");
        assert!(descent.height_mm < 0.6 * heights[0], "seed {seed}: {heights:?}");
    }
    assert!(travelled > 0, "at {travelled} of 150 pauses it stood higher than before");
}

#[test]
fn a_pace_of_endless_failures_does_not_stop_a_descent() {
    let instance = blocks(&[DVec3::new(24.0, 11.0, 7.0), DVec3::splat(10.0)], 2);
    let prepared = coarsely_prepared(&instance);
    let start = tower(&prepared);
    let mut descent = CompressionRun::new(&prepared, &start, ChaCha8Rng::seed_from_u64(1));
    descent.pace.failures = u64::MAX;
    let spent = |evaluations: u64| evaluations as f64 / EVALUATIONS as f64;
    descent.run(&CompressionBudget { spent_share_at: &spent, until: 1.0, lower_bound_mm: 0.0 }, &mut |_, _| {});
    assert!(descent.height_mm < height_mm(&start));
}

#[test]
fn only_parts_that_differ_change_places() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut swapped = |sizes: &[DVec3], copies: u32| {
        let instance = blocks(sizes, copies);
        let prepared = coarsely_prepared(&instance);
        let mut layout = WorkingLayout::new(&prepared, &tower(&prepared), 400.0);
        let centers = |layout: &WorkingLayout<'_>| layout.poses.iter().map(|pose| pose.center).collect::<Vec<_>>();
        let before = centers(&layout);
        (swap_similar_parts(&mut layout, &mut rng), before, centers(&layout))
    };
    let (moved, before, after) = swapped(&[DVec3::splat(10.0)], 4);
    assert!(!moved && before == after);
    let (moved, mut before, after) = swapped(&[DVec3::splat(10.0), DVec3::new(11.0, 12.0, 10.0)], 1);
    before.reverse();
    assert!(moved && before == after, "{before:?}, {after:?}");
}
