//! Heuristics for a first layout: the order of the parts, and their preferred places. Flower pollination proposes some
//! of them.

use std::{cmp::Reverse, collections::BTreeMap};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::{
    pollination::{GeneBoundary, GeneRange},
    shapes::outline::OutlinedInstance,
};

/// The order of the parts, and their preferred places.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlacementRecipe {
    /// 0 volume of the box, 1 longest edge, 2 largest face, 3 shortest edge.
    pub(crate) order: usize,
    /// Weight of the part's height in the score: 1 = lowest top, 0 = lowest bottom.
    pub(crate) top_share: f64,
    /// Weight of the pull towards x = 0; the rest pulls towards y = 0.
    pub(crate) pull_x: f64,
    /// Random variation of the sizes, 0 = none.
    pub(crate) shuffle: f64,
}

impl PlacementRecipe {
    /// The recipes that are tried first.
    pub(crate) const FIRST: [Self; 4] = [
        Self { order: 0, top_share: 1.0, pull_x: 0.5, shuffle: 0.0 },
        Self { order: 1, top_share: 0.8, pull_x: 0.9, shuffle: 0.0 },
        Self { order: 2, top_share: 1.0, pull_x: 0.1, shuffle: 0.0 },
        Self { order: 3, top_share: 0.6, pull_x: 0.9, shuffle: 0.0 },
    ];

    /// The gene ranges of a recipe.
    pub(crate) fn gene_ranges() -> Vec<GeneRange> {
        let gene = |upper: f64| GeneRange { lower: 0.0, upper, edge: GeneBoundary::Reflect };
        vec![gene(3.99), gene(1.0), gene(1.0), gene(0.6)]
    }

    /// Decodes a recipe from a genome.
    pub(crate) fn from_genes(genome: &[f64]) -> Self {
        Self { order: genome[0] as usize, top_share: genome[1], pull_x: genome[2], shuffle: genome[3] }
    }

    /// Copies in the order of this recipe, largest first; copies of one item stay together.
    pub(crate) fn sort_copies(
        &self,
        outlined: &OutlinedInstance,
        copies: &[(usize, u32)],
        rng: &mut ChaCha8Rng,
    ) -> Vec<(usize, u32)> {
        let mut sizes: BTreeMap<usize, i64> = BTreeMap::new();
        for &(item, _) in copies {
            sizes.entry(item).or_insert_with(|| {
                let size = 2.0 * outlined.outlined_item(item).outline.obb.half_mm;
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
