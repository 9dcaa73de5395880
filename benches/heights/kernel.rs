//! Compares the clearance tree with parry3d's triangle meshes: queries per CPU second on the same pairs.

use parry3d_f64::{
    math::Pose3,
    query::{self, ClosestPoints},
    shape::TriMesh,
};

use super::{
    cpu_time::cpu_secs,
    pairs::{self, PartPairs},
    record_book::{KernelRecord, MeasurementOrigin},
};

/// Pairs of each set.
const PAIRS: usize = 200;
/// Least CPU seconds for each kind of query.
const SECS: f64 = 1.0;

/// Measures all sets of pairs.
pub fn measured(origin: &MeasurementOrigin) -> Vec<KernelRecord> {
    pairs::all(PAIRS).iter().map(|pairs| record(pairs, origin)).collect()
}

fn record(pairs: &PartPairs, origin: &MeasurementOrigin) -> KernelRecord {
    let (trees, poses, cap) = (&pairs.trees, &pairs.poses, pairs.clearance_mm);
    let meshes = trees.iter().map(|tree| {
        let mesh = tree.mesh();
        TriMesh::new(mesh.vertices().to_vec(), mesh.triangles().to_vec()).expect("a solid is a triangle mesh")
    });
    let meshes: Vec<TriMesh> = meshes.collect();
    let seen: Vec<Pose3> = poses.iter().map(|(.., pose)| Pose3::from_parts(pose.translation, pose.rotation)).collect();
    let ours = |at: usize| trees[poses[at].0].distance_capped_mm(&trees[poses[at].1], &poses[at].2, cap);
    let closer =
        |at: usize| f64::from(u8::from(trees[poses[at].0].is_closer_than(&trees[poses[at].1], &poses[at].2, cap)));
    let pair = |at: usize| (&meshes[poses[at].0], &meshes[poses[at].1]);
    let parry = |at: usize| {
        let found = query::distance(&Pose3::IDENTITY, pair(at).0, &seen[at], pair(at).1);
        found.expect("knows triangle meshes").distance
    };
    let parry_capped = |at: usize| {
        let found = query::closest_points(&Pose3::IDENTITY, pair(at).0, &seen[at], pair(at).1, cap);
        match found.expect("knows triangle meshes") {
            ClosestPoints::WithinMargin(one, two) => one.distance(two).min(cap),
            ClosestPoints::Intersecting => 0.0,
            ClosestPoints::Disjoint => cap,
        }
    };
    let difference_mm = (0..poses.len()).map(|at| (ours(at) - parry(at).min(cap)).abs()).fold(0.0, f64::max);
    let triangles = trees.iter().map(|tree| tree.mesh().triangles().len()).sum::<usize>() / trees.len();
    let record = KernelRecord {
        pairs: pairs.name.clone(),
        triangles,
        distances_per_sec: per_second(poses.len(), ours),
        answers_per_sec: per_second(poses.len(), closer),
        parry_distances_per_sec: per_second(poses.len(), parry),
        parry_capped_per_sec: per_second(poses.len(), parry_capped),
        difference_mm,
        origin: origin.clone(),
    };
    println!(
        "{}: {:.0} distances and {:.0} answers per second, parry3d {:.0} distances and {:.0} capped ones; at most {:.1e} mm apart",
        record.pairs,
        record.distances_per_sec,
        record.answers_per_sec,
        record.parry_distances_per_sec,
        record.parry_capped_per_sec,
        record.difference_mm
    );
    record
}

/// Queries per CPU second, with the same number of queries for each pair.
fn per_second(pairs: usize, query: impl Fn(usize) -> f64) -> f64 {
    let began = cpu_secs();
    let (mut asked, mut sum) = (0, 0.0);
    while cpu_secs() - began < SECS {
        for at in 0..pairs {
            sum += query(at);
        }
        asked += pairs;
    }
    std::hint::black_box(sum);
    (asked as f64 / (cpu_secs() - began)).round()
}
