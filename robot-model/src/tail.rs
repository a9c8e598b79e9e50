//! Tails of distributions: how probable is at least this much by chance?

/// Probability that a chi-squared variable with `freedom` degrees of freedom exceeds `x`.
///
/// The regularised incomplete gamma function Q(freedom/2, x/2): by its series below its mean, by
/// Legendre's continued fraction above (Abramowitz and Stegun 6.5.29 and 6.5.31).
pub(crate) fn chi_squared(freedom: usize, x: f64) -> f64 {
    let (a, x) = (freedom as f64 / 2.0, x / 2.0);
    if x.is_nan() || x <= 0.0 {
        return 1.0;
    }
    let front = (a * x.ln() - x - ln_gamma_half(freedom)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        let mut n = a;
        while term > 1e-16 * sum {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        (1.0 - front * sum).clamp(0.0, 1.0)
    } else {
        // Lentz's method; it needs some sqrt(a) + 20 rounds here.
        let tiny = 1e-300;
        let mut b = x + 1.0 - a;
        let mut c = 1.0 / tiny;
        let mut d = 1.0 / b;
        let mut h = d;
        for i in 1..500 {
            let an = -f64::from(i) * (f64::from(i) - a);
            b += 2.0;
            d = 1.0 / nonzero(an * d + b, tiny);
            c = nonzero(b + an / c, tiny);
            h *= d * c;
            if (d * c - 1.0).abs() < 1e-15 {
                break;
            }
        }
        (front * h).clamp(0.0, 1.0)
    }
}

fn nonzero(x: f64, tiny: f64) -> f64 {
    if x.abs() < tiny { tiny } else { x }
}

/// ln Gamma(n / 2), by its recursion from Gamma(1/2) = sqrt(pi) or Gamma(1) = 1.
fn ln_gamma_half(n: usize) -> f64 {
    let (mut sum, mut at) =
        if n % 2 == 1 { (0.5 * core::f64::consts::PI.ln(), 0.5) } else { (0.0, 1.0) };
    while at + 0.5 < n as f64 / 2.0 {
        sum += f64::ln(at);
        at += 1.0;
    }
    sum
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
        assert_eq!(chi_squared(3, 0.0), 1.0);
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
