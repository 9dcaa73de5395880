//! Means and how far they can be trusted.

/// Half of the 95 % interval of a mean, in standard deviations of the mean.
pub const HALF_INTERVAL: f64 = 1.96;

/// The mean of a sample, and the variance of that mean; both NaN for an empty sample, the variance also for one value.
pub fn mean_and_variance(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    (mean, squares / (count - 1.0) / count)
}
