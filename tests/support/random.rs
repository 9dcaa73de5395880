//! Random clearances and tilts for random builds.

use rand::{RngExt, seq::IndexedRandom};
use rand_chacha::ChaCha8Rng;

/// A random clearance, from very small to large.
pub fn any_clearance_mm(rng: &mut ChaCha8Rng) -> f64 {
    [0.3, 5.0, rng.random_range(0.3..5.0), rng.random_range(0.3..5.0)].choose(rng).copied().unwrap()
}

/// A random direction with an angle, in the format of the command line; sometimes along an axis.
pub fn any_tilt(rng: &mut ChaCha8Rng, degrees: std::ops::Range<u32>) -> String {
    let mut number = || rng.random_range(-2..=2);
    let (x, y, z) = (number(), number(), number());
    let (x, y, z) = if (x, y, z) == (0, 0, 0) { (0, 0, 1) } else { (x, y, z) };
    format!("{x},{y},{z}:{}", rng.random_range(degrees))
}
