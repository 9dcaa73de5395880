//! Pairs of parts as a tight layout has them: turned at random, moved together until they stand a little more than the
//! clearance apart, or somewhat nearer.

use std::sync::Arc;

use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};
use sample_parts::{Workload, workload};
use solids::{
    ClearanceTree, Mesh, Pose,
    fixtures::{tight, unit},
};

/// How near the parts of a pair stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Nearness {
    /// At most 0.05 mm more than the clearance: nothing can be told before all has been looked at.
    Clear,
    /// Nearer than the clearance, half of it on average.
    Short,
}

/// Pairs to ask a kernel about.
pub struct Pairs {
    /// What they are.
    pub name: String,
    /// The different parts.
    pub trees: Vec<ClearanceTree>,
    /// (one part, other part, the other seen from the one).
    pub poses: Vec<(usize, usize, Pose)>,
    /// Clearance that is asked about, mm.
    pub clearance_mm: f64,
}

/// All sets of pairs, `count` of each.
pub fn all(count: usize) -> Vec<Pairs> {
    let small = Workload::Small { copies: 40, meshes: 40, seed: 7 };
    let piles =
        [("fans", Workload::Fans, 3.0), ("engine-like parts", Workload::EngineLike, 3.0), ("small parts", small, 2.0)];
    let nearness = [Nearness::Clear, Nearness::Short];
    piles.iter().flat_map(|&(name, pile, mm)| nearness.map(|near| pairs(name, pile, mm, near, count))).collect()
}

/// Pairs out of a pile.
pub fn pairs(name: &str, pile: Workload, clearance_mm: f64, near: Nearness, count: usize) -> Pairs {
    let meshes: Vec<Arc<Mesh>> = workload(pile).into_iter().map(|(mesh, _)| Arc::new(mesh)).collect();
    let trees: Vec<ClearanceTree> = meshes.into_iter().map(ClearanceTree::new).collect();
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let any = |rng: &mut ChaCha8Rng| (rng.next_u64() % trees.len() as u64) as usize;
    let poses = (0..count)
        .map(|_| {
            let (one, two) = (any(&mut rng), any(&mut rng));
            let gap_mm = match near {
                Nearness::Clear => clearance_mm,
                Nearness::Short => 0.5 * clearance_mm * (1.0 + 0.8 * unit(&mut rng)),
            };
            (one, two, tight(&trees[one], &trees[two], gap_mm, &mut rng))
        })
        .collect();
    let told = match near {
        Nearness::Clear => "just clear",
        Nearness::Short => "too close",
    };
    Pairs { name: format!("{name}, {told}"), trees, poses, clearance_mm }
}
