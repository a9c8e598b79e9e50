//! What is one unknown, averaged over how much the robot may have wandered?

use super::heading_random_walk::PIECES;
use crate::numeric::distributions::{SIGMAS_95, normal_tail};
use crate::numeric::mixed_model::{MixedModel, Solution};

/// An estimate averaged over the variance of the wandering.
pub(super) struct Averaged {
    pub(super) value: f64,
    pub(super) sigma: f64,
    /// The likeliest of the solutions, and the variance of a piece's turn in it.
    pub(super) best: Solution,
    pub(super) best_variance: f64,
}

/// Averages one unknown over the variance of the random ones, weighted by their likelihood: (7), (8).
///
/// `heading_sigma_rad` is the sigma of the turn over the whole run without wandering. The prior: wandering is
/// between 1 and 128 times that, equally likely at each factor of sqrt 2. One track cannot tell less from none,
/// so a robot that does not wander at all gets a cautious sigma.
pub(super) fn average_over_variance(
    model: &MixedModel,
    heading_sigma_rad: f64,
    unknown: usize,
) -> Option<Averaged> {
    // A factor of sqrt 2 in sigma is one of 2 in variance.
    let variance =
        |doublings: usize| heading_sigma_rad.powi(2) * 2_f64.powi(doublings as i32) / PIECES as f64;
    let mut solutions = Vec::new();
    for doublings in 0..=14 {
        solutions.push(model.solve(variance(doublings))?);
    }
    let best = (0..solutions.len())
        .max_by(|&a, &b| solutions[a].log_likelihood.total_cmp(&solutions[b].log_likelihood))?;
    let top = solutions[best].log_likelihood;
    let weights: Vec<_> = solutions.iter().map(|each| (each.log_likelihood - top).exp()).collect();
    let total: f64 = weights.iter().sum();
    // The answer with each variance: its weight, value and sigma.
    let answers: Vec<_> = solutions
        .iter()
        .zip(weights)
        .map(|(solution, weight)| {
            let sigma = solution.covariance[(unknown, unknown)].sqrt();
            (weight / total, solution.values[unknown], sigma)
        })
        .collect();
    let value: f64 = answers.iter().map(|(weight, value, _)| weight * value).sum();
    let widest = answers
        .iter()
        .fold(0.0_f64, |most, (_, mean, sigma)| most.max(sigma + (mean - value).abs()));

    // (8): the half width outside which 5 % of the mixture lie, by bisection.
    let outside = |half: f64| -> f64 {
        let tails = |mean: f64, sigma: f64| {
            normal_tail((half - mean + value) / sigma) + normal_tail((half + mean - value) / sigma)
        };
        answers.iter().map(|(weight, mean, sigma)| weight * tails(*mean, *sigma)).sum()
    };
    let (mut low, mut high) = (0.0, 3.0 * widest);
    for _ in 0..50 {
        let middle = (low + high) / 2.0;
        if outside(middle) > 0.05 { low = middle } else { high = middle }
    }
    Some(Averaged {
        value,
        sigma: high / SIGMAS_95,
        best_variance: variance(best),
        best: solutions.swap_remove(best),
    })
}
