//! How sure is W_T? From the least-squares solution to W_T with all its uncertainty.

use super::average_over_variance::average_over_variance;
use super::error::TrackFitError;
use super::heading_random_walk::PIECES;
use super::residuals::Residuals;
use super::result::{Estimate, TrackFit};
use super::run::{Beta, Run, SCALE, WEIGHT};
use crate::calibration::wheel_weight::uncertainty::{Contribution, Source};
use crate::calibration::wheel_weight::weight::{Advice, Angle, WheelWeight};
use crate::numeric::mixed_model::MixedModel;

impl Run<'_> {
    /// From the least-squares solution to W_T with all its uncertainty.
    pub(super) fn with_uncertainty(&self, mut beta: Beta) -> Result<TrackFit, TrackFitError> {
        let fixed = self.unknowns();
        let lines = self.lines(&beta, PIECES);
        let noise = self.noise_scale(&lines);
        let mut model = MixedModel::new(fixed, PIECES);
        for line in &lines {
            model.add(&line.row, line.residual, noise * line.sigma);
        }
        let white = model.solve(0.0).ok_or(TrackFitError::NotConverged)?;
        let white_sigma = white.covariance[(WEIGHT, WEIGHT)].sqrt();

        let turns = self.turns();
        let lever = self.geometry.wheel_radius_m * turns.right / self.geometry.track_width_m;
        let wander = average_over_variance(&model, white_sigma * lever.abs(), WEIGHT)
            .ok_or(TrackFitError::NotConverged)?;
        let sigma = wander.sigma.max(white_sigma);

        let residuals = Residuals::of(&lines);
        let best = &wander.best;
        let fitted = self.fitted(&beta, best);
        beta.step(self.options, &best.values.as_slice()[..fixed]);
        let start = fitted[0];
        let end = fitted[fitted.len() - 1].seen_from(start);
        let (end_offset_sigma_m, end_heading_sigma_rad) =
            self.end_sigmas(&beta, best, wander.best_variance);
        let estimate = |place: usize, value: f64| Estimate {
            value,
            sigma: best.covariance[(place, place)].sqrt(),
        };
        Ok(TrackFit {
            wheel_weight: self.wheel_weight(
                beta.wheel_weight + wander.value - best.values[WEIGHT],
                white_sigma,
                sigma,
                beta.scale,
            ),
            start,
            end,
            end_offset_sigma_m,
            end_heading_sigma_rad,
            delay_s: self.options.delay.then(|| estimate(SCALE + 1, beta.delay_s)),
            scale: estimate(SCALE, beta.scale),
            white_sigma,
            wander_sigma: wander.sigma,
            position_rms_m: residuals.position_rms_m,
            heading_rms_rad: residuals.heading_rms_rad,
            chi: residuals.chi,
            fitted,
        })
    }

    /// W_T with its budget: the track's noise, wandering, and the tolerance of b.
    fn wheel_weight(&self, value: f64, white: f64, sigma: f64, scale: f64) -> WheelWeight {
        let turns = self.turns();
        let radius_m = self.geometry.wheel_radius_m * scale;
        let (left_m, right_m) = (radius_m * turns.left, radius_m * turns.right);
        let track_m = self.geometry.track_width_m;
        let alpha_rad = (left_m - value * right_m) / track_m;
        // The track shows the angle alpha and the scale; an error of b changes W_T in proportion.
        let by_track = alpha_rad / right_m;
        let contributions = vec![
            Contribution { source: Source::TrackNoise, sigma: white },
            Contribution {
                source: Source::Wander,
                sigma: (sigma * sigma - white * white).max(0.0).sqrt(),
            },
            Contribution {
                source: Source::TrackWidth,
                sigma: by_track * self.geometry.track_width_sigma_m,
            },
        ];
        let alpha = Angle { rad: alpha_rad, sigma_rad: (right_m / track_m * sigma).abs() };
        let weight = WheelWeight::from_parts(value, alpha, turns, contributions);
        let advice = Advice::for_track(&weight);
        WheelWeight { advice, ..weight }
    }
}
