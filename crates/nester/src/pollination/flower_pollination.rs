//! The flower pollination algorithm (FPA) with an ask/tell interface: it proposes a vector and receives its fitness; it
//! evaluates nothing itself.

use rand::Rng;
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

use super::levy::LevyFlight;

/// How a gene that a step carries over its bounds is treated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GeneBoundary {
    /// The gene stays at the bound (a place against a wall).
    #[cfg_attr(not(feature = "paper"), allow(dead_code, reason = "only the published method asks for it"))]
    Clamp,
    /// The gene is reflected at the bound.
    Reflect,
    /// The gene continues at the other end, and differences are taken the short way round (an angle).
    Wrap,
}

/// The range of one number of a genome: `lower <= gene <= upper`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GeneRange {
    /// Least value.
    pub lower: f64,
    /// Greatest value, at least `lower`.
    pub upper: f64,
    /// Treatment of values beyond the range.
    pub edge: GeneBoundary,
}

impl GeneRange {
    fn span(&self) -> f64 {
        self.upper - self.lower
    }

    /// The value brought back into the range.
    fn bring_into_range(&self, value: f64) -> f64 {
        let span = self.span();
        if span <= 0.0 || !value.is_finite() {
            return if value > self.upper { self.upper } else { self.lower };
        }
        let kept = match self.edge {
            GeneBoundary::Clamp => value,
            GeneBoundary::Wrap => self.lower + (value - self.lower).rem_euclid(span),
            GeneBoundary::Reflect => {
                let along = (value - self.lower).rem_euclid(2.0 * span);
                self.lower + along.min(2.0 * span - along)
            }
        };
        kept.clamp(self.lower, self.upper)
    }

    /// `to - from`, the short way round for a gene that wraps.
    fn difference(&self, to: f64, from: f64) -> f64 {
        let plain = to - from;
        if self.edge != GeneBoundary::Wrap || self.span() <= 0.0 {
            return plain;
        }
        let half = 0.5 * self.span();
        (plain + half).rem_euclid(self.span()) - half
    }
}

/// Parameters of the algorithm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PollinationSettings {
    /// Number of flowers, at least 1.
    pub population: usize,
    /// Probability of global pollination p.
    pub switch_probability: f64,
    /// Scale gamma of a global step, equation (1).
    pub scale: f64,
    /// Exponent lambda of the Levy flight, in (0, 2).
    pub levy_exponent: f64,
    /// No pollination: every proposal after a start is uniformly random. This shows the benefit of pollination.
    pub even: bool,
}

impl Default for PollinationSettings {
    fn default() -> Self {
        Self { population: 25, switch_probability: 0.2, scale: 0.1, levy_exponent: 1.5, even: false }
    }
}

/// A flower: its genome, and its fitness once a feasible one is known.
#[derive(Debug, Clone)]
struct FlowerState<F> {
    genome: Vec<f64>,
    fitness: Option<F>,
    started: bool,
}

/// A population of flowers and its best g*. Smaller fitness is better; `F` must be totally ordered over the values that
/// are passed in.
///
/// Flowers take turns: [`ask`](Self::ask) proposes a genome for the present flower, [`tell`](Self::tell) or
/// [`skip_turn`](Self::skip_turn) ends its turn. A first turn proposes the flower's start.
#[derive(Debug, Clone)]
pub struct FlowerPollination<F> {
    setup: PollinationSettings,
    flight: LevyFlight,
    genes: Vec<GeneRange>,
    flowers: Vec<FlowerState<F>>,
    turn: usize,
    proposal: Vec<f64>,
    best: Option<(Vec<f64>, F)>,
    rng: ChaCha8Rng,
}

impl<F: PartialOrd + Clone> FlowerPollination<F> {
    /// A population over `genes`, scattered uniformly. The same seed and the same fitness values give the same
    /// proposals on every machine. The settings are clamped to their ranges.
    pub fn new(setup: PollinationSettings, genes: Vec<GeneRange>, seed: u64) -> Self {
        let setup = PollinationSettings {
            population: setup.population.max(1),
            switch_probability: setup.switch_probability.clamp(0.0, 1.0),
            levy_exponent: setup.levy_exponent.clamp(0.1, 1.99),
            ..setup
        };
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let flowers = (0..setup.population)
            .map(|_| FlowerState { genome: random_genome(&genes, &mut rng), fitness: None, started: false })
            .collect();
        let flight = LevyFlight::new(setup.levy_exponent);
        Self { setup, flight, proposal: Vec::with_capacity(genes.len()), genes, flowers, turn: 0, best: None, rng }
    }

    /// Sets the starts of the first flowers to given genomes (brought into the bounds) instead of random ones.
    ///
    /// # Panics
    /// When a genome has another length than the genes.
    #[must_use]
    pub fn starting_at(mut self, starts: impl IntoIterator<Item = Vec<f64>>) -> Self {
        for (flower, start) in self.flowers.iter_mut().zip(starts) {
            assert_eq!(start.len(), self.genes.len(), "a genome has one number per gene");
            flower.genome = start.iter().zip(&self.genes).map(|(&value, gene)| gene.bring_into_range(value)).collect();
        }
        self
    }

    /// Returns a genome to try for the present flower: its start at first, then a global step (equation (1)) with
    /// probability p or else a local one (equation (5)). Asking again without telling draws another one for the same
    /// flower.
    pub fn ask(&mut self) -> &[f64] {
        let flower = &mut self.flowers[self.turn];
        if !flower.started {
            flower.started = true;
            self.proposal.clone_from(&flower.genome);
        } else if self.setup.even || flower.fitness.is_none() && self.best.is_none() {
            // There is no known genome to move towards, or uniform sampling is required.
            self.proposal = random_genome(&self.genes, &mut self.rng);
        } else if random_unit(&mut self.rng) < self.setup.switch_probability {
            self.propose_global();
        } else {
            self.propose_local();
        }
        &self.proposal
    }

    /// Receives the fitness of the last proposal. The flower moves there if it is better than its own place; then the
    /// next flower takes its turn. Returns whether the proposal is the best so far.
    pub fn tell(&mut self, fitness: F) -> bool {
        let is_best = self.best.as_ref().is_none_or(|(_, best)| fitness < *best);
        if is_best {
            self.best = Some((self.proposal.clone(), fitness.clone()));
        }
        let flower = &mut self.flowers[self.turn];
        if flower.fitness.as_ref().is_none_or(|own| fitness < *own) {
            flower.genome.clone_from(&self.proposal);
            flower.fitness = Some(fitness);
        }
        self.skip_turn();
        is_best
    }

    /// Leaves the flower unchanged; the next flower takes its turn.
    pub fn skip_turn(&mut self) {
        self.turn = (self.turn + 1) % self.flowers.len();
    }

    /// The fitness of the present flower's own genome: a proposal must be better to replace it. `None` until one was
    /// reported.
    pub fn own_fitness(&self) -> Option<&F> {
        self.flowers[self.turn].fitness.as_ref()
    }

    /// The best genome so far, g*, and its fitness.
    #[cfg_attr(not(feature = "paper"), allow(dead_code, reason = "only the published method asks for it"))]
    pub fn best(&self) -> Option<(&[f64], &F)> {
        self.best.as_ref().map(|(genome, fitness)| (genome.as_slice(), fitness))
    }

    /// The genomes of the flowers with a known fitness, the best first.
    pub fn ranked_genomes(&self) -> Vec<&[f64]> {
        let known = self.flowers.iter().filter_map(|flower| Some((flower.fitness.as_ref()?, flower.genome.as_slice())));
        let mut ranked: Vec<(&F, &[f64])> = known.collect();
        ranked.sort_by(|a, b| a.0.partial_cmp(b.0).unwrap_or(std::cmp::Ordering::Equal));
        ranked.into_iter().map(|(_, genome)| genome).collect()
    }

    /// Equation (1): x + gamma L(lambda) (g* - x), with a separate step for every gene.
    fn propose_global(&mut self) {
        let own = &self.flowers[self.turn].genome;
        let best = self.best.as_ref().map_or(own, |(genome, _)| genome);
        self.proposal.clear();
        for ((gene, &x), &goal) in self.genes.iter().zip(own).zip(best) {
            let step = self.setup.scale * self.flight.draw_step(&mut self.rng);
            self.proposal.push(gene.bring_into_range(x + step * gene.difference(goal, x)));
        }
    }

    /// Equation (5): x + epsilon (x_j - x_k) with two other flowers and one epsilon out of [0, 1].
    fn propose_local(&mut self) {
        let count = self.flowers.len() as u64;
        let (j, k) = (random_index(count, &mut self.rng), random_index(count, &mut self.rng));
        let epsilon = random_unit(&mut self.rng);
        let [own, j, k] = [self.turn, j, k].map(|i| &self.flowers[i].genome);
        self.proposal.clear();
        self.proposal.extend(
            (self.genes.iter().zip(own).zip(j.iter().zip(k)))
                .map(|((gene, &x), (&j, &k))| gene.bring_into_range(x + epsilon * gene.difference(j, k))),
        );
    }
}

fn random_genome(genes: &[GeneRange], rng: &mut ChaCha8Rng) -> Vec<f64> {
    genes.iter().map(|gene| gene.bring_into_range(gene.lower + random_unit(rng) * gene.span())).collect()
}

/// A uniform number in [0, 1) from the upper 53 bits. Its definition does not depend on a library version.
fn random_unit(rng: &mut ChaCha8Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

/// A uniform index below `count`; the bias of the remainder is negligible.
fn random_index(count: u64, rng: &mut ChaCha8Rng) -> usize {
    (rng.next_u64() % count) as usize
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn genes(count: usize, edge: GeneBoundary) -> Vec<GeneRange> {
        vec![GeneRange { lower: -5.12, upper: 5.12, edge }; count]
    }

    fn sphere(x: &[f64]) -> f64 {
        x.iter().map(|x| (x - 1.0).powi(2)).sum()
    }

    fn rastrigin(x: &[f64]) -> f64 {
        x.iter().map(|x| x * x - 10.0 * (std::f64::consts::TAU * x).cos() + 10.0).sum()
    }

    fn best_of(function: fn(&[f64]) -> f64, evaluations: usize, seed: u64) -> f64 {
        best_by(PollinationSettings::default(), function, evaluations, seed)
    }

    fn best_by(setup: PollinationSettings, function: fn(&[f64]) -> f64, evaluations: usize, seed: u64) -> f64 {
        let mut search = FlowerPollination::new(setup, genes(4, GeneBoundary::Reflect), seed);
        for _ in 0..evaluations {
            let value = function(search.ask());
            search.tell(value);
        }
        *search.best().unwrap().1
    }

    fn best_even(function: fn(&[f64]) -> f64, evaluations: usize, seed: u64) -> f64 {
        best_by(PollinationSettings { even: true, ..PollinationSettings::default() }, function, evaluations, seed)
    }

    #[test]
    fn it_beats_even_sampling_at_the_same_evaluations() {
        for (function, name, factor) in
            [(sphere as fn(&[f64]) -> f64, "sphere", 1e-3), (rastrigin as fn(&[f64]) -> f64, "Rastrigin", 0.5)]
        {
            for seed in 0..5 {
                let (ours, even) = (best_of(function, 20_000, seed), best_even(function, 20_000, seed));
                assert!(ours < factor * even, "{name}, seed {seed}: {ours} against {even}");
            }
        }
    }

    #[test]
    fn the_same_seed_takes_the_same_course() {
        assert_eq!(best_of(rastrigin, 3_000, 11), best_of(rastrigin, 3_000, 11));
        assert_ne!(best_of(rastrigin, 3_000, 11), best_of(rastrigin, 3_000, 12));
    }

    #[test]
    fn asking_again_draws_anew_for_the_same_flower() {
        let mut search = FlowerPollination::new(
            PollinationSettings { population: 2, ..PollinationSettings::default() },
            genes(2, GeneBoundary::Clamp),
            1,
        )
        .starting_at([vec![1.0, 2.0], vec![9.0, -9.0]]);
        assert_eq!(search.ask(), [1.0, 2.0]);
        assert_ne!(search.ask(), [1.0, 2.0], "without any fitness, a new random place");
        search.skip_turn();
        assert_eq!(search.ask(), [5.12, -5.12], "a start is brought into the bounds");
        assert!(search.tell(3.0));
        search.skip_turn();
        assert_eq!(search.own_fitness(), Some(&3.0));
        search.ask();
        assert!(!search.tell(4.0), "worse");
        assert_eq!(search.best().unwrap(), ([5.12, -5.12].as_slice(), &3.0));
    }

    proptest! {
        #[test]
        fn genes_keep_their_bounds(value in -1e4..1e4f64, lower in -9.0..9.0f64, span in 0.0..9.0f64) {
            for edge in [GeneBoundary::Clamp, GeneBoundary::Reflect, GeneBoundary::Wrap] {
                let gene = GeneRange { lower, upper: lower + span, edge };
                for value in [value, f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
                    let kept = gene.bring_into_range(value);
                    prop_assert!(kept >= gene.lower && kept <= gene.upper, "{edge:?} {value} -> {kept}");
                }
                let inside = lower + 0.5 * span;
                prop_assert!((gene.bring_into_range(inside) - inside).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn angles_meet_the_short_way_round() {
        let angle = GeneRange { lower: -3.0, upper: 3.0, edge: GeneBoundary::Wrap };
        assert!((angle.difference(-2.9, 2.9) - 0.2).abs() < 1e-12);
        assert!((angle.bring_into_range(3.1) + 2.9).abs() < 1e-12);
        let wall = GeneRange { edge: GeneBoundary::Reflect, ..angle };
        assert!((wall.bring_into_range(3.1) - 2.9).abs() < 1e-12 && (wall.bring_into_range(-3.5) + 2.5).abs() < 1e-12);
    }
}
