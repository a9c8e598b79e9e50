//! How sure is the end of the run?

use super::heading_random_walk::PIECES;
use super::run::{Beta, Run, START};
use crate::numeric::mixed_model::Solution;

impl Run<'_> {
    /// (9): sigmas of offset and heading at the end, relative to the start pose: an error of the start pose moves
    /// the line together with the end.
    pub(super) fn end_sigmas(
        &self,
        beta: &Beta,
        best: &Solution,
        piece_variance: f64,
    ) -> (f64, f64) {
        let local = self.local(beta.wheel_weight, beta.delay_s, beta.scale);
        let wandering = self.random_walk(beta, &local, PIECES);
        let last = local.len() - 1;
        let (sin, cos) = beta.start.heading_rad.sin_cos();
        let mut offset = vec![0.0; START];
        let mut heading = vec![0.0; START];
        for d in self.shape_derivatives(beta) {
            offset.push(d[last].y_m);
            heading.push(d[last].heading_rad);
        }
        for u in &wandering[last] {
            offset.push(-sin * u.x_m + cos * u.y_m);
            heading.push(u.heading_rad);
        }
        let sigma = |g: Vec<f64>| {
            let size = best.values.len();
            let variance: f64 = (0..size)
                .flat_map(|i| (0..size).map(move |j| (i, j)))
                .map(|(i, j)| g[i] * best.covariance[(i, j)] * g[j])
                .sum();
            variance.max(0.0).sqrt()
        };
        // Wandering within the first piece is not resolved: a third of the variance of its turn stays in the
        // start heading and turns the whole run about the start.
        let unresolved_rad = (piece_variance / 3.0).sqrt();
        let reach_m = local[last].x_m;
        (sigma(offset).hypot(reach_m * unresolved_rad), sigma(heading).hypot(unresolved_rad))
    }
}
