//! Least squares with two kinds of unknowns: fixed ones, which have no prior, and random ones, each drawn from a
//! normal distribution of known variance. The numbers of the equations are those of `docs/how-sure-is-w-t.md`.
//!
//! ```text
//! r = J beta + Z u + e,   e ~ N(0, 1) after weighting,   u ~ N(0, v)                  (3)
//! [JJ  JZ      ] [beta]   [Jr]
//! [ZJ  ZZ + 1/v] [u   ] = [Zr]          Henderson's equations, matrix M                (4)
//! -2 log L(v) = log|M| + m log v + rr - [Jr Zr] M^-1 [Jr Zr]    restricted likelihood  (5)
//! ```

use nalgebra::{Cholesky, DMatrix, DVector};

/// The normal equations of (3), summed up row by row.
pub(crate) struct MixedModel {
    fixed: usize,
    normal: DMatrix<f64>,
    right: DVector<f64>,
    squares: f64,
}

/// The solution of (4).
pub(crate) struct Solution {
    /// The fixed unknowns, then the random ones.
    pub(crate) values: DVector<f64>,
    /// Their covariance.
    pub(crate) covariance: DMatrix<f64>,
    /// (5), up to a constant that is the same for every variance.
    pub(crate) log_likelihood: f64,
}

impl MixedModel {
    pub(crate) fn new(fixed: usize, random: usize) -> Self {
        let size = fixed + random;
        Self {
            fixed,
            normal: DMatrix::zeros(size, size),
            right: DVector::zeros(size),
            squares: 0.0,
        }
    }

    /// Adds one residual with its derivatives by all unknowns.
    pub(crate) fn add(&mut self, row: &[f64], residual: f64, sigma: f64) {
        let weight = 1.0 / (sigma * sigma);
        for (i, a) in row.iter().enumerate() {
            self.right[i] += weight * a * residual;
            for (j, b) in row[..=i].iter().enumerate() {
                self.normal[(i, j)] += weight * a * b;
            }
        }
        self.squares += weight * residual * residual;
    }

    /// Solves (4) for random unknowns of this variance; with zero variance they are left out.
    ///
    /// `None` if the rows do not determine the unknowns.
    pub(crate) fn solve(&self, variance: f64) -> Option<Solution> {
        let size = if variance > 0.0 { self.normal.nrows() } else { self.fixed };
        // Cholesky reads the lower triangle alone.
        let mut matrix = self.normal.view((0, 0), (size, size)).into_owned();
        for i in self.fixed..size {
            matrix[(i, i)] += 1.0 / variance;
        }
        let right = self.right.rows(0, size).into_owned();
        let factor = Cholesky::new(matrix)?;
        let values = factor.solve(&right);
        let log_determinant = 2.0 * factor.l_dirty().diagonal().map(f64::ln).sum();
        let random = (size - self.fixed) as f64;
        let log_variance = if random > 0.0 { random * variance.ln() } else { 0.0 };
        let left = self.squares - right.dot(&values);
        Some(Solution {
            covariance: factor.inverse(),
            log_likelihood: -0.5 * (log_determinant + log_variance + left),
            values,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::Random;

    #[test]
    fn without_random_unknowns_it_is_least_squares() {
        let mut model = MixedModel::new(2, 0);
        for x in 0..5 {
            let x = f64::from(x);
            model.add(&[1.0, x], 3.0 - 2.0 * x, 0.1);
        }
        let found = model.solve(0.0).unwrap();
        assert!((found.values[0] - 3.0).abs() < 1e-12 && (found.values[1] + 2.0).abs() < 1e-12);
        // sigma^2 / sum (x - mean)^2 = 0.01 / 10.
        assert!((found.covariance[(1, 1)] - 0.001).abs() < 1e-15);
    }

    #[test]
    fn unknowns_that_no_row_determines_have_no_solution() {
        let mut model = MixedModel::new(2, 0);
        model.add(&[1.0, 0.0], 1.0, 1.0);
        assert!(model.solve(0.0).is_none());
    }

    #[test]
    fn the_likelihood_is_largest_near_the_true_variance() {
        // 200 groups of 5: the variance of the groups is known to 2/sqrt(200) x sqrt(2), about 12 %.
        let mut noise = Random::new(3);
        let groups = 200;
        let mut model = MixedModel::new(1, groups);
        for group in 0..groups {
            let shift = 2.0 * noise.normal();
            for _ in 0..5 {
                let mut row = vec![0.0; 1 + groups];
                row[0] = 1.0;
                row[1 + group] = 1.0;
                model.add(&row, 7.0 + shift + noise.normal(), 1.0);
            }
        }
        let at = |variance| model.solve(variance).unwrap().log_likelihood;
        assert!(at(4.0) > at(2.0) && at(4.0) > at(8.0));
        let mean = model.solve(4.0).unwrap();
        // Groups of variance 4 + 1/5, 200 of them: sigma 0.145.
        assert!((mean.covariance[(0, 0)].sqrt() - 0.145).abs() < 1e-3);
        assert!((mean.values[0] - 7.0).abs() < 4.0 * 0.145);
    }
}
