//! Figures: soft bodies with bent limbs, as sculptors and orthopaedists send them.

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use solids::Mesh;

use crate::making::{
    distance_functions::{DistanceFunction, limb_distance, union},
    implicit::mesh_of_field,
};

/// Joints of a limb.
const JOINTS: usize = 3;

/// A figure of a random build: a trunk with three to six limbs of three segments, 40 to 110 mm across. The same seed
/// always gives the same figure.
pub fn random_figure(seed: u64) -> Mesh {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let size = rng.random_range(14.0..30.0);
    let slim = rng.random_range(0.45..0.8);
    let mut direction = || DVec3::from_array([(); 3].map(|()| rng.random_range(-1.0..1.0))).normalize_or(DVec3::Z);
    let trunk_axis = direction();
    let ways: Vec<[DVec3; JOINTS]> = (0..6).map(|_| [(); JOINTS].map(|()| direction())).collect();
    let (head, tail) = (trunk_axis * 0.6 * size, trunk_axis * -0.6 * size);
    let mut balls = vec![(head, 0.8 * slim * size), (tail, slim * size)];
    let mut bodies: Vec<DistanceFunction> = vec![limb_distance(balls[0], balls[1])];
    for (number, bends) in ways.iter().take(rng.random_range(3..=6)).enumerate() {
        let mut from = (if number % 2 == 0 { head } else { tail }, 0.42 * slim * size);
        let mut way = bends[0];
        for bend in bends {
            way = (way + 0.6 * *bend).normalize_or(way);
            let to = (from.0 + way * size * rng.random_range(0.45..0.8), from.1 * 0.85);
            bodies.push(limb_distance(from, to));
            balls.push(to);
            from = to;
        }
    }
    let min = balls.iter().map(|(center, radius)| *center - *radius).fold(DVec3::INFINITY, DVec3::min);
    let max = balls.iter().map(|(center, radius)| *center + *radius).fold(DVec3::NEG_INFINITY, DVec3::max);
    // A fillet lifts the surface by at most a quarter of its width.
    let fillet = 0.25 * slim * size;
    mesh_of_field(&union(bodies, fillet), min - 0.25 * fillet, max + 0.25 * fillet, size / 12.0)
}
