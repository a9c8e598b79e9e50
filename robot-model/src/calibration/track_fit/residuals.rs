//! What are the residuals of a fit, and how noisy do they show the track to be?

use super::run::{Beta, Run};
use super::scatter::{noise_of, second_differences};
use crate::numeric::angle::wrap;

/// One residual and its derivatives, ready for the normal equations.
pub(super) struct Line {
    pub(super) row: Vec<f64>,
    pub(super) residual: f64,
    pub(super) sigma: f64,
}

impl Run<'_> {
    /// The residual equations (3) at `beta`: x, y and, where measured, heading of each sample.
    pub(super) fn lines(&self, beta: &Beta, pieces: usize) -> Vec<Line> {
        let local = self.local(beta.wheel_weight, beta.delay_s, beta.scale);
        let derivatives = self.shape_derivatives(beta);
        let wandering = self.random_walk(beta, &local, pieces);
        let (sin, cos) = beta.start.heading_rad.sin_cos();
        let mut lines = Vec::with_capacity(3 * self.samples.len());
        for (i, (sample, local)) in self.samples.iter().zip(&local).enumerate() {
            let pose = beta.start.compose(*local);
            let mut rows = [
                vec![1.0, 0.0, beta.start.y_m - pose.y_m],
                vec![0.0, 1.0, pose.x_m - beta.start.x_m],
                vec![0.0, 0.0, 1.0],
            ];
            for d in derivatives.iter().map(|all| all[i]) {
                rows[0].push(cos * d.x_m - sin * d.y_m);
                rows[1].push(sin * d.x_m + cos * d.y_m);
                rows[2].push(d.heading_rad);
            }
            for u in &wandering[i] {
                rows[0].push(u.x_m);
                rows[1].push(u.y_m);
                rows[2].push(u.heading_rad);
            }
            let [x, y, heading] = rows;
            let sigma = self.position_sigma_m;
            lines.push(Line { row: x, residual: sample.x_m - pose.x_m, sigma });
            lines.push(Line { row: y, residual: sample.y_m - pose.y_m, sigma });
            if let Some(heading_rad) = sample.heading_rad {
                let residual = wrap(heading_rad - pose.heading_rad);
                lines.push(Line { row: heading, residual, sigma: self.heading_sigma_rad });
            }
        }
        lines
    }

    /// (6): by what factor the noise is larger than stated, from second differences of the residuals, which
    /// wandering hardly changes; at least 1.
    pub(super) fn noise_scale(&self, lines: &[Line]) -> f64 {
        let mut differences = Vec::new();
        for axis in 0..2 {
            let scaled: Vec<_> = lines
                .iter()
                .filter(|line| line.row[axis] == 1.0 && line.row[..axis].iter().all(|a| *a == 0.0))
                .map(|line| line.residual / line.sigma)
                .collect();
            differences.extend(second_differences(&scaled));
        }
        noise_of(differences).max(1.0)
    }
}

/// The root mean squares of the residuals.
pub(super) struct Residuals {
    pub(super) position_rms_m: f64,
    pub(super) heading_rms_rad: f64,
    pub(super) chi: f64,
}

impl Residuals {
    pub(super) fn of(lines: &[Line]) -> Self {
        let rms = |values: &mut dyn Iterator<Item = f64>| {
            let (sum, count) = values.fold((0.0, 0_u32), |(sum, n), v| (sum + v * v, n + 1));
            (sum / f64::from(count.max(1))).sqrt()
        };
        let is_heading = |line: &&Line| line.row[0] == 0.0 && line.row[1] == 0.0;
        Self {
            position_rms_m: rms(&mut lines.iter().filter(|l| !is_heading(l)).map(|l| l.residual)),
            heading_rms_rad: rms(&mut lines.iter().filter(is_heading).map(|l| l.residual)),
            chi: rms(&mut lines.iter().map(|line| line.residual / line.sigma)),
        }
    }
}
