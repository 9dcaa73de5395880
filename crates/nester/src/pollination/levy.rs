//! Levy flights by Mantegna's algorithm: mostly short steps, sometimes a very long one.

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// Draws steps s = U / |V|^(1/lambda), equation (3), whose tail follows equation (2).
#[derive(Debug, Clone, Copy)]
pub(super) struct LevyFlight {
    lambda: f64,
    sigma: f64,
}

impl LevyFlight {
    /// `lambda` in (0, 2).
    ///
    /// The spread is Mantegna's, sigma = [Gamma(1 + l) sin(pi l / 2) / (Gamma((1 + l) / 2) l 2^((l - 1) / 2))]^(1 / l).
    /// The paper's equation (4) has the same terms but calls the left side sigma squared; this follows Mantegna, where it
    /// is sigma.
    pub fn new(lambda: f64) -> Self {
        let above = gamma_function(1.0 + lambda) * (std::f64::consts::FRAC_PI_2 * lambda).sin();
        let below = gamma_function((1.0 + lambda) / 2.0) * lambda * 2f64.powf((lambda - 1.0) / 2.0);
        Self { lambda, sigma: (above / below).powf(1.0 / lambda) }
    }

    /// One step, of either sign.
    pub fn draw_step(&self, rng: &mut impl Rng) -> f64 {
        let normal = |rng: &mut _| -> f64 { StandardNormal.sample(rng) };
        let (u, v) = (normal(rng) * self.sigma, normal(rng));
        u / v.abs().max(f64::MIN_POSITIVE).powf(1.0 / self.lambda)
    }
}

/// The Gamma function for positive numbers by Lanczos' approximation (g = 7, nine terms), to 15 digits.
fn gamma_function(x: f64) -> f64 {
    const TERMS: [f64; 9] = [
        0.999_999_999_999_809_9,
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_1,
        -176.615_029_162_140_6,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_572e-6,
        1.505_632_735_149_311_6e-7,
    ];
    let x = x - 1.0;
    let sum = TERMS[0] + (1..9).map(|i| TERMS[i] / (x + i as f64)).sum::<f64>();
    let t = x + 7.5;
    (2.0 * std::f64::consts::PI).sqrt() * t.powf(x + 0.5) * (-t).exp() * sum
}

#[cfg(test)]
mod tests {
    use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

    use super::*;

    #[test]
    fn gamma_is_known_at_known_places() {
        for (x, value) in [(1.0, 1.0), (5.0, 24.0), (0.5, 1.772_453_850_905_516), (2.5, 1.329_340_388_179_137)] {
            assert!((gamma_function(x) / value - 1.0).abs() < 1e-13, "{x}");
        }
    }

    #[test]
    fn sigma_is_mantegnas() {
        // The value for 1.5 that implementations of FPA and cuckoo search share.
        assert!((LevyFlight::new(1.5).sigma - 0.696_574_502_557_696_8).abs() < 1e-12);
        assert!((LevyFlight::new(1.0).sigma - 1.0).abs() < 1e-12, "a Cauchy distribution");
    }

    #[test]
    fn quantiles_are_those_of_a_levy_flight() {
        // For lambda 1 the ratio of two normals is Cauchy: quartiles at 1, |s| above tan(0.45 pi) in 10 % of the cases.
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let share = |lambda: f64, limit: f64, rng: &mut ChaCha8Rng| {
            let flight = LevyFlight::new(lambda);
            (0..200_000).filter(|_| flight.draw_step(rng).abs() > limit).count() as f64 / 200_000.0
        };
        assert!((share(1.0, 1.0, &mut rng) - 0.5).abs() < 0.005);
        assert!((share(1.0, (0.45 * std::f64::consts::PI).tan(), &mut rng) - 0.1).abs() < 0.003);
        // Far out, equation (2) integrates to 2 Gamma(l) sin(pi l / 2) / pi x s^-l.
        let (far, lambda) = (20.0, 1.5);
        let tail = 2.0 * gamma_function(lambda) * (lambda * std::f64::consts::FRAC_PI_2).sin() / std::f64::consts::PI;
        let expected = tail * f64::powf(far, -lambda);
        assert!((share(lambda, far, &mut rng) / expected - 1.0).abs() < 0.2, "expected {expected}");
    }

    #[test]
    fn steps_go_both_ways() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let flight = LevyFlight::new(1.5);
        let up = (0..20_000).filter(|_| flight.draw_step(&mut rng) > 0.0).count();
        assert!((9_600..10_400).contains(&up), "{up}");
    }
}
