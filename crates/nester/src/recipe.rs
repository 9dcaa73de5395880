//! How a first layout takes its parts: the order, and where each likes to stand. Flowers propose some of them.

use std::{cmp::Reverse, collections::BTreeMap};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::outline::Lineup;
use crate::pollination::{Edge, Gene};

/// How parts are taken and where they like to stand.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Recipe {
    /// 0 volume of the box, 1 longest edge, 2 largest face, 3 shortest edge.
    pub(crate) order: usize,
    /// Share of the part's height in the score: 1 = lowest top, 0 = lowest bottom.
    pub(crate) top_share: f64,
    /// Pull towards x = 0 rather than y = 0.
    pub(crate) pull_x: f64,
    /// Random factor on the sizes, 0 = none.
    pub(crate) shuffle: f64,
}

impl Recipe {
    /// The recipes that are tried before any others.
    pub(crate) const FIRST: [Self; 4] = [
        Self { order: 0, top_share: 1.0, pull_x: 0.5, shuffle: 0.0 },
        Self { order: 1, top_share: 0.8, pull_x: 0.9, shuffle: 0.0 },
        Self { order: 2, top_share: 1.0, pull_x: 0.1, shuffle: 0.0 },
        Self { order: 3, top_share: 0.6, pull_x: 0.9, shuffle: 0.0 },
    ];

    /// The ranges of a genome that stands for a recipe.
    pub(crate) fn genes() -> Vec<Gene> {
        let gene = |upper: f64| Gene { lower: 0.0, upper, edge: Edge::Reflect };
        vec![gene(3.99), gene(1.0), gene(1.0), gene(0.6)]
    }

    /// The recipe that a genome stands for.
    pub(crate) fn of_genes(genome: &[f64]) -> Self {
        Self { order: genome[0] as usize, top_share: genome[1], pull_x: genome[2], shuffle: genome[3] }
    }

    /// Copies in the order of this recipe, largest first; equal ones stay together.
    pub(crate) fn sorted(&self, lineup: &Lineup, copies: &[(usize, u32)], rng: &mut ChaCha8Rng) -> Vec<(usize, u32)> {
        let mut sizes: BTreeMap<usize, i64> = BTreeMap::new();
        for &(item, _) in copies {
            sizes.entry(item).or_insert_with(|| {
                let size = 2.0 * lineup.candidate(item).outline.obb.half_mm;
                let (short, long) = (size.min_element(), size.max_element());
                let middle = size.element_sum() - short - long;
                let key = [short * middle * long, long, middle * long, short][self.order];
                (key * (1.0 + self.shuffle * rng.random_range(-1.0..1.0)) * 1e3) as i64
            });
        }
        let mut sorted = copies.to_vec();
        sorted.sort_by_key(|&(item, copy)| (Reverse(sizes[&item]), item, copy));
        sorted
    }
}
