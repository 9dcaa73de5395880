//! Speed of the clearance tree on real parts, which are in `NESTD_DATA`.

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

use crate::{
    ClearanceTree, Pose,
    fixtures::{mesh_from_data, tight_pose},
};

/// CPU seconds of this thread, so that other work on the machine does not count.
fn cpu_secs() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").expect("the tests run on Linux");
    text.split(' ').next().and_then(|n| n.parse::<f64>().ok()).expect("starts with nanoseconds") * 1e-9
}

#[test]
#[ignore = "needs NESTD_DATA=<folder>: cargo test -p solids -- --ignored"]
#[allow(clippy::print_stderr)]
fn a_tight_pair_is_answered_in_microseconds() {
    let files = ["nest/fan/fan_90mm_test.STL", "nest/so101/Base_SO101.stl", "nest/compressor/Casting_Mold.STL"];
    for file in files {
        let mesh = mesh_from_data(file).expect("the parts are in NESTD_DATA");
        let start = cpu_secs();
        let part = ClearanceTree::new(mesh.clone());
        let built = cpu_secs() - start;
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let poses: Vec<Pose> = (0..300).map(|_| tight_pose(&part, &part, 3.0, &mut rng)).collect();
        // The clock ticks in milliseconds: the same poses many times.
        let poses = poses.repeat(5);
        let mut sum = 0.0;
        let start = cpu_secs();
        for pose in &poses {
            sum += part.distance_capped_mm(&part, pose, 3.0);
        }
        let capped = (cpu_secs() - start) * 1e6 / poses.len() as f64;
        let start = cpu_secs();
        let closer = poses.iter().filter(|p| part.is_closer_than(&part, p, 3.2)).count();
        let yes = (cpu_secs() - start) * 1e6 / poses.len() as f64;
        let start = cpu_secs();
        let top: f64 = poses.iter().map(|p| part.bounds_at(p).max.z).sum();
        let bounds = (cpu_secs() - start) * 1e6 / poses.len() as f64;
        assert!(sum == 3.0 * poses.len() as f64 && top.is_finite());
        eprintln!(
            "{file}: {} triangles, built in {built:.3} s, tight pair {capped:.1} us, closer_than 3.2 {yes:.1} us ({closer} yes), bounds {bounds:.2} us",
            mesh.triangles().len()
        );
    }
}
