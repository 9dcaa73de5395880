//! Tests of the first layouts: what they cost, and what finer voxels are good for.

use std::sync::Arc;

use glam::DVec3;
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};
use solids::MeshBuilder;

use super::{
    nester_tests::{asked, item},
    testing::block,
};
use crate::{
    NestingConfig, NestingInstance, OrientationRule, PreparedMeshes, SearchBudget,
    prepare::prepared_instance::height_mm,
    separation::interlock_check::split_separable,
    start::{
        first_layouts::finer_voxels, layout_builder::LayoutBuilder, nesting_run::NestingRun, recipe::PlacementRecipe,
    },
};

/// Runs a test with a search that has made nothing yet.
fn with_run<T>(instance: &NestingInstance, budget: &SearchBudget, test: impl FnOnce(&mut NestingRun<'_>) -> T) -> T {
    let (config, meshes) = (NestingConfig::default(), PreparedMeshes::default());
    test(&mut NestingRun::new(instance, &config, &meshes, budget, &mut ()))
}

#[test]
fn finer_voxels_leave_less_air_between_parts() {
    let instance =
        asked(DVec3::new(12.0, 12.0, 60.0), 1.0, vec![item(block(DVec3::splat(10.3)), 3, OrientationRule::Fixed)]);
    with_run(&instance, &SearchBudget::until_cancelled(), |run| {
        let task = run.prepare_instance(Arc::new(run.outline_instance())).expect("there is time");
        let height = |mut builder: LayoutBuilder<'_>| {
            let built = builder.build_separable(&PlacementRecipe::FIRST[0], &task.copies, &[], &mut |_| false);
            let pieces = built.expect("nothing ends it");
            assert_eq!(pieces.len(), 3);
            height_mm(&pieces)
        };
        let (coarse, fine) = (height(LayoutBuilder::new(&task)), height(LayoutBuilder::finer_by(&task, 2.0)));
        assert!(fine < coarse - 0.1 && fine >= 3.0 * 10.3 + 2.0, "{fine} {coarse}");
    });
}

#[test]
fn voxels_are_as_fine_as_what_is_left_of_the_share_allows() {
    assert_eq!(finer_voxels(0.06, 0.06), None);
    assert_eq!(finer_voxels(-0.1, 0.02), None);
    let factor = finer_voxels(0.06, 0.02).expect("there is room for three layouts");
    assert!((1.5..1.6).contains(&factor), "{factor}");
    // An endless budget is no reason for endless voxels.
    assert_eq!(finer_voxels(0.1, 0.0), Some(2.0));
}

#[test]
fn first_layouts_keep_to_their_share_of_the_budget() {
    let clip = Arc::new(sample_parts::clip(22.0, 2.4, 14.0));
    let instance = asked(DVec3::new(60.0, 60.0, 120.0), 1.5, vec![item(clip, 12, OrientationRule::Free)]);
    let made_of = |evaluations: u64| {
        with_run(&instance, &SearchBudget::of_evaluations(evaluations), |run| {
            let task = run.prepare_instance(Arc::new(run.outline_instance())).expect("there is time");
            run.build_first_layouts(&task, &[]);
            assert_eq!(run.best_items.len(), 12);
            run.evaluations
        })
    };
    // With a budget that is used up by it, only the very first one is built.
    let first = made_of(1);
    assert_eq!(made_of(10 * first), first, "nothing more fits into a tenth");
    for evaluations in [15 * first, 40 * first, 100 * first] {
        let made = made_of(evaluations);
        // A layout that is under way ends after the part at which the share is used up.
        assert!(made > first && made as f64 <= 0.1 * evaluations as f64 + 0.3 * first as f64, "{made} {first}");
    }
}

#[test]
fn a_draft_may_lock_parts_and_a_layout_made_of_it_may_not() {
    let cages = sample_parts::workload_parts(sample_parts::SampleWorkload::Cages);
    let items = cages.into_iter().map(|(mesh, _)| item(Arc::new(mesh), 1, OrientationRule::Free)).collect();
    let instance = asked(DVec3::new(120.0, 120.0, 600.0), 3.0, items);
    with_run(&instance, &SearchBudget::until_cancelled(), |run| {
        let task = run.prepare_instance(Arc::new(run.outline_instance())).expect("there is time");
        assert!(task.must_be_separable);
        let recipe = PlacementRecipe::FIRST[0];
        let order = recipe.sort_copies(&task.outlined, &task.copies, &mut ChaCha8Rng::seed_from_u64(1));
        let mut builder = LayoutBuilder::new(&task);
        let draft = builder.build_once(&recipe, &order, &[], f64::INFINITY, &mut |_| false).expect("nothing ends it");
        assert!(!split_separable(&task, draft.clone()).1.is_empty());
        let made = builder.make_separable(&recipe, &order, draft, &mut |_| false).expect("nothing ends it");
        assert_eq!((made.len(), split_separable(&task, made).1.len()), (task.copies.len(), 0));
    });
}

#[test]
fn a_part_is_not_put_on_top_because_a_few_places_below_fail_the_exact_test() {
    // The pin stands near the corner at which the places are tried first.
    assert!(height_beside_pin(31.0, [1.5, 1.5], 30.0) < 33.0);
}

#[test]
fn a_part_is_put_on_top_where_the_first_place_without_failure_is_higher() {
    // Each place below the top of the pin fails. The box ends at its top; the voxels leave air above it.
    let height = height_beside_pin(8.6, [20.0, 20.0], 41.0);
    assert!((19.7..19.71).contains(&height), "{height}");
}

/// The height of a layout of a plate with a pin, too thin for the voxels, and a block of 10 mm, in millimetres.
fn height_beside_pin(pin_mm: f64, pin_at: [f64; 2], block_mm: f64) -> f64 {
    let (plate, pin) = (block(DVec3::new(40.0, 40.0, 2.0)), block(DVec3::new(0.3, 0.3, pin_mm)));
    let mut pinned_plate = MeshBuilder::default();
    for (solid, place) in [(plate, DVec3::ZERO), (pin, DVec3::new(pin_at[0], pin_at[1], 1.0))] {
        let corners = (0..solid.triangles().len()).map(|triangle| solid.corners(triangle));
        corners.for_each(|corners| pinned_plate.add_triangle(corners.map(|corner| corner + place)));
    }
    let pinned_plate = pinned_plate.into_mesh().expect("two closed shells");
    let items = vec![
        item(Arc::new(pinned_plate), 1, OrientationRule::Fixed),
        item(block(DVec3::new(block_mm, block_mm, 10.0)), 1, OrientationRule::Fixed),
    ];
    let instance = asked(DVec3::new(42.0, 42.0, 100.0), 0.1, items);
    with_run(&instance, &SearchBudget::until_cancelled(), |run| {
        let task = run.prepare_instance(Arc::new(run.outline_instance())).expect("there is time");
        let mut builder = LayoutBuilder::new(&task);
        let built = builder.build_once(&PlacementRecipe::FIRST[0], &task.copies, &[], f64::INFINITY, &mut |_| false);
        let pieces = built.expect("nothing ends it");
        assert_eq!(pieces.len(), 2);
        height_mm(&pieces)
    })
}
