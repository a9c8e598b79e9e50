//! Which path do the wheel angles predict, and which W_T fits the track best without wandering?

use super::error::TrackFitError;
use super::result::FitOptions;
use super::track::{Track, TrackSample, WheelAngles};
use crate::kinematics::geometry::Geometry;
use crate::kinematics::pose::{Pose, dead_reckon};
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::mixed_model::MixedModel;

/// All unknowns but the wandering.
#[derive(Clone, Copy)]
pub(super) struct Beta {
    pub(super) start: Pose,
    pub(super) wheel_weight: f64,
    pub(super) delay_s: f64,
    pub(super) scale: f64,
}

/// Places of the unknowns in a row: x0, y0, theta0, W_T, the scale, then the delay if it is fitted.
pub(super) const START: usize = 3;
pub(super) const WEIGHT: usize = 3;
pub(super) const SCALE: usize = 4;

impl Beta {
    pub(super) fn step(&mut self, options: FitOptions, by: &[f64]) {
        self.start.x_m += by[0];
        self.start.y_m += by[1];
        self.start.heading_rad += by[2];
        self.wheel_weight += by[WEIGHT];
        self.scale += by[SCALE];
        if options.delay {
            self.delay_s += by[SCALE + 1];
        }
    }
}

/// The data of a fit.
pub(super) struct Run<'a> {
    pub(super) samples: Vec<TrackSample>,
    angles: &'a [WheelAngles],
    pub(super) geometry: &'a Geometry,
    pub(super) options: FitOptions,
    pub(super) position_sigma_m: f64,
    pub(super) heading_sigma_rad: f64,
}

impl<'a> Run<'a> {
    pub(super) fn new(
        track: &Track,
        angles: &'a [WheelAngles],
        geometry: &'a Geometry,
        options: FitOptions,
    ) -> Result<Self, TrackFitError> {
        let time = angles[0].t_s..=angles[angles.len() - 1].t_s;
        let samples: Vec<_> =
            track.samples.iter().filter(|sample| time.contains(&sample.t_s)).copied().collect();
        // Ten points for up to six unknowns and their scatter.
        if samples.len() < 10 {
            return Err(TrackFitError::TooFewSamples { found: samples.len(), needed: 10 });
        }
        // (2): counts are whole: each travel is off by a uniform part of Q, variance Q^2/12. The middle
        // of the robot sees half of the sum, its heading the difference over b.
        let quantum_m = geometry.meters_per_count() / 12_f64.sqrt();
        let run = Self {
            samples,
            angles,
            geometry,
            options,
            position_sigma_m: track.position_sigma_m.hypot(quantum_m / 2_f64.sqrt()),
            heading_sigma_rad: track
                .heading_sigma_rad
                .hypot(quantum_m * 2_f64.sqrt() / geometry.track_width_m),
        };
        let turns = run.turns();
        // A tenth of a radian at the wheel shows nothing of the radii.
        if turns.left.abs() < 0.1 || turns.right.abs() < 0.1 {
            return Err(TrackFitError::NoTravel);
        }
        Ok(run)
    }

    /// Wheel angles at a time, held at the ends.
    pub(super) fn turns_at(&self, t_s: f64) -> (usize, WheelPair<f64>) {
        let after = self.angles.partition_point(|angles| angles.t_s <= t_s);
        let after = after.clamp(1, self.angles.len() - 1);
        let (a, b) = (&self.angles[after - 1], &self.angles[after]);
        let share = ((t_s - a.t_s) / (b.t_s - a.t_s)).clamp(0.0, 1.0);
        (after - 1, a.turns.toward(b.turns, share))
    }

    /// How far the wheels turned from the first sample to the last.
    pub(super) fn turns(&self) -> WheelPair<f64> {
        let [first, last] =
            [0, self.samples.len() - 1].map(|i| self.turns_at(self.samples[i].t_s).1);
        last.since(first)
    }

    /// Predicted poses at the samples, in the frame of the first: p(t) of (1).
    pub(super) fn local(&self, wheel_weight: f64, delay_s: f64, scale: f64) -> Vec<Pose> {
        let geometry =
            Geometry { wheel_radius_m: self.geometry.wheel_radius_m * scale, ..*self.geometry };
        let turns = self.angles.iter().map(|angles| angles.turns);
        let knots = dead_reckon(Pose::ORIGIN, &geometry, wheel_weight, turns);
        let mut poses: Vec<_> = self
            .samples
            .iter()
            .map(|sample| {
                let (knot, turns) = self.turns_at(sample.t_s - delay_s);
                let step = turns.since(self.angles[knot].turns);
                knots[knot].advance(
                    geometry.wheel_radius_m * step.left,
                    geometry.wheel_radius_m * wheel_weight * step.right,
                    geometry.track_width_m,
                )
            })
            .collect();
        let first = poses[0];
        for pose in &mut poses {
            *pose = pose.seen_from(first);
        }
        poses
    }

    /// Derivatives of the local poses by W_T, the scale and, if it is fitted, the delay.
    pub(super) fn shape_derivatives(&self, beta: &Beta) -> Vec<Vec<Pose>> {
        let Beta { wheel_weight: w, delay_s: d, scale: k, .. } = *beta;
        let mut all = Vec::new();
        let mut difference = |step: f64, high: Vec<Pose>, low: Vec<Pose>| {
            let pairs = high.into_iter().zip(low);
            all.push(
                pairs
                    .map(|(high, low)| Pose {
                        x_m: (high.x_m - low.x_m) / (2.0 * step),
                        y_m: (high.y_m - low.y_m) / (2.0 * step),
                        heading_rad: (high.heading_rad - low.heading_rad) / (2.0 * step),
                    })
                    .collect::<Vec<_>>(),
            );
        };
        let h = 1e-5;
        difference(h, self.local(w + h, d, k), self.local(w - h, d, k));
        difference(h, self.local(w, d, k + h), self.local(w, d, k - h));
        if self.options.delay {
            // Long enough that whole counts hardly change the speed.
            let h = 0.02;
            difference(h, self.local(w, d + h, k), self.local(w, d - h, k));
        }
        all
    }

    /// The number of unknowns without wandering.
    pub(super) fn unknowns(&self) -> usize {
        SCALE + 1 + usize::from(self.options.delay)
    }

    /// The start pose with which equal wheels fit the track best (Procrustes).
    fn first_guess(&self) -> Beta {
        let local = self.local(1.0, 0.0, 1.0);
        let n = local.len() as f64;
        let mean = |read: &dyn Fn(usize) -> f64| (0..local.len()).map(read).sum::<f64>() / n;
        let (mx, my) = (mean(&|i| self.samples[i].x_m), mean(&|i| self.samples[i].y_m));
        let (lx, ly) = (mean(&|i| local[i].x_m), mean(&|i| local[i].y_m));
        let (mut dot, mut cross) = (0.0, 0.0);
        for (sample, local) in self.samples.iter().zip(&local) {
            let (x, y) = (sample.x_m - mx, sample.y_m - my);
            let (u, v) = (local.x_m - lx, local.y_m - ly);
            dot += u * x + v * y;
            cross += u * y - v * x;
        }
        let heading_rad = cross.atan2(dot);
        let (sin, cos) = heading_rad.sin_cos();
        let start = Pose::new(mx - cos * lx + sin * ly, my - sin * lx - cos * ly, heading_rad);
        Beta { start, wheel_weight: 1.0, delay_s: 0.0, scale: 1.0 }
    }

    /// Gauss-Newton without wandering.
    pub(super) fn least_squares(&self) -> Result<Beta, TrackFitError> {
        let mut beta = self.first_guess();
        for _ in 0..30 {
            let mut model = MixedModel::new(self.unknowns(), 0);
            for line in self.lines(&beta, 0) {
                model.add(&line.row, line.residual, line.sigma);
            }
            let step = model.solve(0.0).ok_or(TrackFitError::NotConverged)?;
            beta.step(self.options, step.values.as_slice());
            if !(0.5..2.0).contains(&beta.wheel_weight) || !(0.5..2.0).contains(&beta.scale) {
                return Err(TrackFitError::NotConverged);
            }
            // A hundredth of its own sigma is small enough.
            if step.values[WEIGHT].abs() < 0.01 * step.covariance[(WEIGHT, WEIGHT)].sqrt() {
                return Ok(beta);
            }
        }
        Err(TrackFitError::NotConverged)
    }
}
