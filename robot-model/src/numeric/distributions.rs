//! Distributions: how probable is at least this much by chance, and how wide is a 95 % interval?

use statrs::distribution::{ContinuousCDF, StudentsT};
use statrs::function::beta::beta_reg;
use statrs::function::erf::{erfc, erfc_inv};
use statrs::function::gamma::gamma_ur;

/// Half the width of a 95 % interval, in sigmas of a normal distribution.
pub const SIGMAS_95: f64 = 1.959_964;

/// Probability that a chi-squared variable with `freedom` degrees of freedom exceeds `x`.
pub(crate) fn chi_squared(freedom: usize, x: f64) -> f64 {
    if x.is_nan() || x <= 0.0 || freedom == 0 {
        return 1.0;
    }
    // The square of a huge residual; `gamma_ur` takes finite numbers only.
    if x.is_infinite() {
        return 0.0;
    }
    gamma_ur(freedom as f64 / 2.0, x / 2.0).clamp(0.0, 1.0)
}

/// Probability that a chi-squared variable with `freedom` degrees exceeds `x`, if its scale is an estimate with
/// `known_from` degrees of freedom of its own: the tail of Fisher's F at x / freedom.
pub(crate) fn fisher(freedom: usize, known_from: f64, x: f64) -> f64 {
    if x.is_nan() || x <= 0.0 || freedom == 0 {
        return 1.0;
    }
    beta_reg(known_from / 2.0, freedom as f64 / 2.0, known_from / (known_from + x)).clamp(0.0, 1.0)
}

/// Probability that a normal deviate exceeds `x` sigmas.
pub(crate) fn normal_tail(x: f64) -> f64 {
    erfc(x / core::f64::consts::SQRT_2) / 2.0
}

/// The value that Student's t with so many degrees of freedom, above zero, stays below with this probability.
pub fn students_t_quantile(freedom: f64, probability: f64) -> f64 {
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(probability))
}

/// By how many sigmas a normal deviate lies from zero, either way, with this probability of at least as much.
pub(crate) fn normal_sigmas(probability: f64) -> f64 {
    core::f64::consts::SQRT_2 * erfc_inv(probability.clamp(0.0, 1.0))
}

/// Wilcoxon's signed-rank test: the probability that differences which are symmetric about zero have a sum of positive
/// ranks at least this large. Exact; zeros count half.
pub(crate) fn signed_rank(differences: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = differences.to_vec();
    sorted.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    // Twice the sum of positive ranks, so that half a rank is whole.
    let doubled: usize = sorted
        .iter()
        .enumerate()
        .map(|(i, difference)| match difference {
            positive if *positive > 0.0 => 2 * (i + 1),
            negative if *negative < 0.0 => 0,
            _ => i + 1,
        })
        .sum();
    let most = sorted.len() * (sorted.len() + 1) / 2;
    // The probability of each sum of ranks, rank by rank.
    let mut probability = vec![0.0; most + 1];
    probability[0] = 1.0;
    for rank in 1..=sorted.len() {
        for sum in (0..=most).rev() {
            let with = if sum >= rank { probability[sum - rank] } else { 0.0 };
            probability[sum] = (probability[sum] + with) / 2.0;
        }
    }
    probability[doubled / 2..].iter().sum::<f64>().min(1.0)
}

/// Benjamini and Hochberg: the least false discovery rate at which each p-value counts.
pub(crate) fn false_discovery_rates(p_values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|a, b| p_values[*b].total_cmp(&p_values[*a]));
    let count = p_values.len() as f64;
    let mut rates = vec![1.0; p_values.len()];
    let mut least = 1.0_f64;
    for (from_the_top, index) in order.into_iter().enumerate() {
        let rank = count - from_the_top as f64;
        least = least.min(p_values[index] * count / rank);
        rates[index] = least;
    }
    rates
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_are_those_of_the_tables() {
        // Closed forms: exp(-x/2) for two degrees, exp(-x/2)(1 + x/2) for four.
        for x in [0.1, 1.0, 3.0, 9.0, 40.0] {
            assert!((chi_squared(2, x) / f64::exp(-x / 2.0) - 1.0).abs() < 1e-12);
            let four = f64::exp(-x / 2.0) * (1.0 + x / 2.0);
            assert!((chi_squared(4, x) / four - 1.0).abs() < 1e-12);
        }
        // Tables: 3.841459 for one degree and 16.91898 for nine are passed in 5 %; to their digits.
        assert!((chi_squared(1, 3.841459) - 0.05).abs() < 1e-7);
        assert!((chi_squared(9, 16.91898) - 0.05).abs() < 1e-7);
        // The square of a huge residual.
        assert_eq!((chi_squared(4, f64::INFINITY), fisher(4, 9.0, f64::INFINITY)), (0.0, 0.0));
        assert_eq!(chi_squared(3, 0.0), 1.0);
    }

    #[test]
    fn the_normal_tail_is_that_of_the_tables() {
        // 1.959964 sigmas are passed in 2.5 %, and 3 in 0.1349898 %; to their digits.
        assert!((normal_tail(SIGMAS_95) - 0.025).abs() < 1e-7);
        assert!((normal_tail(3.0) - 0.001_349_898).abs() < 1e-9);
        assert!((normal_tail(-1.0) + normal_tail(1.0) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn few_degrees_have_wide_tails() {
        // Tables: t of 5 degrees passes 2.570582 in 5 %, F of 2 and 10 degrees 4.102821; to their digits.
        assert!((fisher(1, 5.0, 2.570582_f64.powi(2)) - 0.05).abs() < 1e-7);
        assert!((fisher(2, 10.0, 2.0 * 4.102821) - 0.05).abs() < 1e-7);
        // Of very many degrees it is chi^2, to one over their number.
        assert!((fisher(3, 1e7, 9.0) / chi_squared(3, 9.0) - 1.0).abs() < 1e-5);
        assert_eq!(fisher(3, 4.0, -1.0), 1.0);
        // Far out, still a number.
        assert!((0.0..1e-40).contains(&fisher(1, 24.0, 1e5)));
    }

    #[test]
    fn sigmas_are_those_of_the_tails_however_small() {
        for sigmas in [0.5, 1.959_964, 5.0, 20.0] {
            let back = normal_sigmas(2.0 * normal_tail(sigmas));
            assert!((back / sigmas - 1.0).abs() < 1e-6, "{sigmas} {back}");
        }
        assert_eq!(normal_sigmas(1.0), 0.0);
        assert_eq!(normal_sigmas(0.0), f64::INFINITY);
    }

    #[test]
    fn signed_ranks_are_those_of_the_tables() {
        // Tables of the signed-rank statistic: of 10 differences, a sum of negative ranks of at most 8 is passed in
        // 2.4 %, of 20 one of at most 43 in 1.0 %; all ten positive in 2^-10.
        let of = |n: usize, negative: &[usize]| {
            let sign = |rank: usize| if negative.contains(&rank) { -1.0 } else { 1.0 };
            signed_rank(&(1..=n).map(|rank| sign(rank) * rank as f64).collect::<Vec<_>>())
        };
        assert!((of(10, &[8]) - 0.0244).abs() < 5e-5, "{}", of(10, &[8]));
        assert!((of(20, &[20, 19, 4]) - 0.0096).abs() < 5e-5, "{}", of(20, &[20, 19, 4]));
        assert_eq!(of(10, &[]), 0.5_f64.powi(10));
        assert_eq!(signed_rank(&[]), 1.0);
    }

    #[test]
    fn false_discovery_rates_are_those_of_the_example() {
        // p m / rank: 0.04, 0.04, 0.04, 0.2 with the least taken from the top.
        let rates = false_discovery_rates(&[0.01, 0.2, 0.02, 0.03]);
        for (got, want) in rates.iter().zip([0.04, 0.2, 0.04, 0.04]) {
            assert!((got - want).abs() < 1e-15, "{rates:?}");
        }
    }
}
