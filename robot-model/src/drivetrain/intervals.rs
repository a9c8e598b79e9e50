//! How sure the constants are: the jackknife over experiments, with Student's t.
//!
//! What is left within an experiment is one error that lasts, a caster's side or a spot of floor, and no independent noise.
//! So each experiment counts as one observation, and the scatter is that of the fits without one of them:
//!
//! ```text
//! d_g  = -(H - H_g)^-1 g_g                    how far the constants go without experiment g, to first order     (1)
//! se^2 = (G - 1) / G  sum (a d_g - mean)^2    of the sum a of constants, G experiments                          (2)
//! w_g  = a H^-1 H_g H^-1 a,   df = (sum w_g)^2 / sum w_g^2 - 1, at least 1                                      (3)
//! ```
//!
//! (3) counts the experiments that tell about `a`: backwards friction shows in those only that go backwards. The half-width
//! is t(0.975, df) se.

use nalgebra::{DMatrix, DVector};

use crate::numeric::distributions::students_t_quantile;

/// One experiment's share of the normal equations, at the fit.
pub(super) struct Share {
    /// H_g.
    pub gram: DMatrix<f64>,
    /// g_g.
    pub gradient: DVector<f64>,
}

/// The intervals of any sum of constants.
pub(super) struct Intervals {
    inverse: DMatrix<f64>,
    shares: Vec<(DMatrix<f64>, DVector<f64>)>,
}

impl Intervals {
    /// From the normal equations `gram`, priors included, and each experiment's share of them. `None` where one experiment
    /// alone tells a constant.
    pub fn new(gram: &DMatrix<f64>, shares: &[Share]) -> Option<Self> {
        let eased = |gram: DMatrix<f64>| {
            let mut eased = gram;
            for i in 0..eased.nrows() {
                eased[(i, i)] += 1e-12 * eased[(i, i)].max(1e-30);
            }
            eased.try_inverse()
        };
        let inverse = eased(gram.clone())?;
        let without = |share: &Share| {
            Some((share.gram.clone(), -eased(gram - &share.gram)? * &share.gradient))
        };
        Some(Self { inverse, shares: shares.iter().map(without).collect::<Option<_>>()? })
    }

    /// Half the width of the 95 % interval of the constants' sum with these weights.
    pub fn half_width_95(&self, weights: &DVector<f64>) -> f64 {
        let (error, degrees) = self.standard_error(weights);
        students_t_quantile(degrees, 0.975) * error
    }

    /// How far the constants' sum with these weights goes with the gradient of each constant.
    pub fn moved(&self, weights: &DVector<f64>) -> DVector<f64> {
        &self.inverse * weights
    }

    /// (2) and (3): the standard error, and its degrees of freedom.
    pub fn standard_error(&self, weights: &DVector<f64>) -> (f64, f64) {
        let count = self.shares.len() as f64;
        let moved = || self.shares.iter().map(|(_, moved)| moved.dot(weights));
        let mean = moved().sum::<f64>() / count;
        let variance =
            (count - 1.0) / count * moved().map(|d| (d - mean) * (d - mean)).sum::<f64>();
        let towards = self.moved(weights);
        let told = self.shares.iter().map(|(gram, _)| (gram * &towards).dot(&towards));
        let (sum, squares) = told.fold((0.0, 0.0), |(sum, squares), w| (sum + w, squares + w * w));
        let degrees = if squares > 0.0 { (sum * sum / squares - 1.0).max(1.0) } else { 1.0 };
        (variance.sqrt(), degrees)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::distributions::fisher;

    /// A constant that every experiment tells alike, with these errors, is their mean; so is its interval.
    #[test]
    fn the_interval_of_a_mean_is_students() {
        let errors = [0.3, -0.5, 0.9, 0.1, -0.8];
        let shares = errors.map(|error| Share {
            gram: DMatrix::from_element(1, 1, 1.0),
            gradient: DVector::from_element(1, error),
        });
        let gram = DMatrix::from_element(1, 1, 5.0);
        let found = Intervals::new(&gram, &shares).unwrap();
        // Their standard deviation is 0.670820, t(0.975, 4) is 2.776445.
        let expected = 2.776_445 * 0.670_820 / 5.0_f64.sqrt();
        let half_width = found.half_width_95(&DVector::from_element(1, 1.0));
        assert!((half_width / expected - 1.0).abs() < 1e-5, "{half_width} {expected}");
    }

    /// Student's t of 3 with two degrees of freedom: one of 10.477, both tails.
    #[test]
    fn a_mean_that_is_three_standard_errors_from_zero_is_chance_as_often_as_students_t_says() {
        let shares = [-1.0, 0.0, 1.0].map(|error| Share {
            gram: DMatrix::from_element(1, 1, 1.0),
            gradient: DVector::from_element(1, error),
        });
        let found = Intervals::new(&DMatrix::from_element(1, 1, 3.0), &shares).unwrap();
        let (error, degrees) = found.standard_error(&DVector::from_element(1, 1.0));
        assert!((error - 3.0_f64.sqrt().recip()).abs() < 1e-9, "{error}");
        let chance = fisher(1, degrees, 9.0);
        assert!((chance - 0.095_466).abs() < 1e-5, "{chance}");
    }

    #[test]
    fn experiments_that_tell_nothing_of_a_constant_make_it_no_surer() {
        let share = |tells: f64, error: f64| Share {
            gram: DMatrix::from_diagonal(&DVector::from_vec(vec![tells, 1.0])),
            gradient: DVector::from_vec(vec![tells * error, -0.1 * error]),
        };
        let few = [share(1.0, 0.2), share(1.0, -0.3), share(1.0, 0.1)];
        let many = [few[0].gradient[0], few[1].gradient[0], few[2].gradient[0]]
            .map(|error| share(1.0, error))
            .into_iter()
            .chain((0..9).map(|i| share(0.0, f64::from(i % 3) - 1.0)))
            .collect::<Vec<_>>();
        let first = DVector::from_vec(vec![1.0, 0.0]);
        let of = |shares: &[Share]| {
            let gram = shares.iter().fold(DMatrix::zeros(2, 2), |sum, share| sum + &share.gram);
            Intervals::new(&gram, shares).unwrap().half_width_95(&first)
        };
        let (few, many) = (of(&few), of(&many));
        assert!(many > 0.8 * few, "{many} {few}");
    }
}
