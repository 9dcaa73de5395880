//! How long it takes from the meshes in memory, their outlines prepared, to the first layout of all copies.
//! `cargo bench --bench construction`.

use std::{hint::black_box, sync::Arc};

use criterion::{Criterion, criterion_group, criterion_main};
use glam::DVec3;
use nester::{BuildVolume, NestingConfig, NestingInstance, NestingItem, PreparedMeshes, SearchBudget, nest_with_cache};
use sample_parts::{SampleWorkload, workload_parts};

fn instance(pile: SampleWorkload, base_mm: [f64; 2], clearance_mm: f64) -> NestingInstance {
    let items = workload_parts(pile).into_iter().map(|(mesh, copies)| NestingItem::new("part", Arc::new(mesh), copies));
    let volume = BuildVolume { size_mm: DVec3::new(base_mm[0], base_mm[1], 600.0) };
    NestingInstance::new(volume, clearance_mm, items.collect()).expect("makes sense")
}

fn first_layouts(criterion: &mut Criterion) {
    let small = |copies, meshes| SampleWorkload::Small { copies, meshes, seed: 7 };
    let mut group = criterion.benchmark_group("first layout");
    group.sample_size(10);
    for (name, instance) in [
        ("20 fans", instance(SampleWorkload::Fans, [200.0, 200.0], 3.0)),
        ("30 engine-like parts", instance(SampleWorkload::EngineLike, [150.0, 150.0], 3.0)),
        ("200 small parts, 40 meshes", instance(small(200, 40), [160.0, 160.0], 2.0)),
    ] {
        let prepared = PreparedMeshes::default();
        // Used up from the beginning: only the first layout is made.
        let budget = SearchBudget::of_evaluations(0);
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                let (instance, config) = (black_box(&instance), NestingConfig::default());
                let solution = nest_with_cache(instance, &config, &[], &prepared, &budget, &mut ());
                assert!(solution.unplaced.is_empty(), "a copy found no place");
                solution.height_mm
            });
        });
    }
    group.finish();
}

criterion_group!(benches, first_layouts);
criterion_main!(benches);
