//! Measures distance queries between parts at tight poses, with the clearance tree and with parry3d on the same pairs,
//! and the time to build a tree: `cargo bench --bench kernel`. The figures of `docs/benchmark.md` are made by
//! `cargo bench --bench heights -- --only kernel`.

#[path = "common/pairs.rs"]
mod pairs;

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use parry3d_f64::{math::Pose3, query, shape::TriMesh};
use solids::ClearanceTree;

/// Pairs of each set; one sample queries all of them.
const PAIRS: usize = 50;

fn distances(criterion: &mut Criterion) {
    for pairs in pairs::all(PAIRS) {
        let (trees, cap) = (&pairs.trees, pairs.clearance_mm);
        let mesh_of = |tree: &ClearanceTree| {
            let mesh = tree.mesh();
            TriMesh::new(mesh.vertices().to_vec(), mesh.triangles().to_vec()).expect("a solid is a triangle mesh")
        };
        let meshes: Vec<TriMesh> = trees.iter().map(mesh_of).collect();
        let mut group = criterion.benchmark_group(&pairs.name);
        group.sample_size(10).throughput(Throughput::Elements(PAIRS as u64));
        group.bench_function("distance, capped at the clearance", |bencher| {
            bencher.iter(|| {
                let distance = |(a, b, pose): &(usize, usize, _)| trees[*a].distance_capped_mm(&trees[*b], pose, cap);
                black_box(pairs.poses.iter().map(distance).sum::<f64>())
            });
        });
        group.bench_function("closer than the clearance", |bencher| {
            bencher.iter(|| {
                let closer = |(a, b, pose): &&(usize, usize, _)| trees[*a].is_closer_than(&trees[*b], pose, cap);
                black_box(pairs.poses.iter().filter(closer).count())
            });
        });
        group.bench_function("parry3d: nearest points, capped at the clearance", |bencher| {
            bencher.iter(|| {
                for (a, b, pose) in &pairs.poses {
                    let pose = Pose3::from_parts(pose.translation, pose.rotation);
                    let _ = black_box(query::closest_points(&Pose3::IDENTITY, &meshes[*a], &pose, &meshes[*b], cap));
                }
            });
        });
        group.finish();
    }
}

fn trees(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("building a tree");
    group.sample_size(10);
    for (name, mesh) in [
        ("fan", sample_parts::axial_fan(65.0, 22.0, 7)),
        ("gyroid ball", sample_parts::gyroid_ball(36.0, 18.0, 3.2)),
        ("spur gear", sample_parts::spur_gear(24, 2.0, 10.0, 10.0)),
    ] {
        let mesh = std::sync::Arc::new(mesh);
        group.throughput(Throughput::Elements(mesh.triangles().len() as u64));
        group.bench_function(name, |bencher| bencher.iter(|| ClearanceTree::new(black_box(mesh.clone()))));
    }
    group.finish();
}

criterion_group!(benches, distances, trees);
criterion_main!(benches);
