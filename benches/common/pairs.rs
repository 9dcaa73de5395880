//! Pairs of parts as in a tight layout: rotated at random and moved together until their distance is slightly more than
//! the clearance, or somewhat less.

use std::sync::Arc;

use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};
use sample_parts::{
    SampleWorkload,
    fixtures::{tight_pose, unit},
    workload_parts,
};
use solids::{ClearanceTree, Mesh, Pose};

/// The distance of the parts of a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PairDistance {
    /// At most 0.05 mm more than the clearance: a query must look at everything before it can answer.
    Clear,
    /// Nearer than the clearance, half of it on average.
    Short,
}

/// Pairs for queries of a kernel.
pub struct PartPairs {
    /// A description of the pairs.
    pub name: String,
    /// The different parts.
    pub trees: Vec<ClearanceTree>,
    /// (one part, other part, the other seen from the one).
    pub poses: Vec<(usize, usize, Pose)>,
    /// Clearance of the queries, mm.
    pub clearance_mm: f64,
}

/// All sets of pairs, `count` of each.
pub fn all(count: usize) -> Vec<PartPairs> {
    let small = SampleWorkload::Small { copies: 40, meshes: 40, seed: 7 };
    let piles = [
        ("fans", SampleWorkload::Fans, 3.0),
        ("engine-like parts", SampleWorkload::EngineLike, 3.0),
        ("small parts", small, 2.0),
    ];
    let nearness = [PairDistance::Clear, PairDistance::Short];
    piles.iter().flat_map(|&(name, pile, mm)| nearness.map(|near| pairs(name, pile, mm, near, count))).collect()
}

/// Pairs from a pile.
pub fn pairs(name: &str, pile: SampleWorkload, clearance_mm: f64, near: PairDistance, count: usize) -> PartPairs {
    let meshes: Vec<Arc<Mesh>> = workload_parts(pile).into_iter().map(|(mesh, _)| Arc::new(mesh)).collect();
    let trees: Vec<ClearanceTree> = meshes.into_iter().map(ClearanceTree::new).collect();
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let any = |rng: &mut ChaCha8Rng| (rng.next_u64() % trees.len() as u64) as usize;
    let poses = (0..count)
        .map(|_| {
            let (one, two) = (any(&mut rng), any(&mut rng));
            let gap_mm = match near {
                PairDistance::Clear => clearance_mm,
                PairDistance::Short => 0.5 * clearance_mm * (1.0 + 0.8 * unit(&mut rng)),
            };
            (one, two, tight_pose(&trees[one], &trees[two], gap_mm, &mut rng))
        })
        .collect();
    let told = match near {
        PairDistance::Clear => "just clear",
        PairDistance::Short => "too close",
    };
    PartPairs { name: format!("{name}, {told}"), trees, poses, clearance_mm }
}
