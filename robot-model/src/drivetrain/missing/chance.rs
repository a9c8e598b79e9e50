//! Is a gain more than chance? Whole experiments are exchanged, never samples.

use super::modes::Modes;
use crate::numeric::random::Random;

/// So many exchanges.
const EXCHANGES: usize = 4000;

/// By how much each experiment is predicted better: half the logarithm of the costs' ratio, of each mode, so that no experiment
/// counts for more than the factor by which its error falls. Below the encoder's resolution nothing is gained.
pub(super) fn gains(before: &[Modes], after: &[Modes], floors: &[f64]) -> Vec<f64> {
    let both = before.iter().zip(after).zip(floors);
    both.map(|((before, after), floor)| {
        before.zip(*after, |before, after| 0.5 * ((before + floor) / (after + floor)).ln()).sum()
    })
    .collect()
}

/// How often gains whose signs chance decides sum up to as much.
pub(super) fn p_value(gains: &[f64]) -> f64 {
    let sum: f64 = gains.iter().sum();
    if !sum.is_finite() || sum <= 0.0 {
        return 1.0;
    }
    let mut random = Random::new(0x6d07_0125);
    let as_much = (0..EXCHANGES)
        .filter(|_| {
            let flipped =
                gains.iter().map(|gain| if random.uniform() < 0.5 { *gain } else { -gain });
            flipped.sum::<f64>() >= sum * (1.0 - 1e-12)
        })
        .count();
    (1.0 + as_much as f64) / (1.0 + EXCHANGES as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn experiments_that_all_gain_are_no_chance_and_half_of_them_are() {
        assert!(p_value(&[0.2; 14]) < 1e-3);
        assert!(p_value(&[0.2, -0.2, 0.1, -0.1, 0.3, -0.25]) > 0.2);
        assert_eq!(p_value(&[-0.1, -0.2]), 1.0);
        // A few that gain much are as likely as their signs: 1 of 8.
        let few = p_value(&[1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
        assert!((0.10..0.15).contains(&few), "{few}");
    }
}
