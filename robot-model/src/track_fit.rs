//! W_T from a whole measured track.
//!
//! The path that the wheel angles predict (exact arcs, radius and track width as given) is laid on
//! the measured points by weighted least squares. Unknown are W_T, the pose at the first sample
//! (always a nuisance, never evidence), a common scale of both radii (a nuisance too: else the length
//! of the track, which says as much of the tolerance of R as of W_T, would pass for evidence) and, if
//! asked for, the delay of the track's clock.
//!
//! **How sure.** Points of a track are not independent evidence of W_T: what bends the real path,
//! beyond the wheels, stays in every later point. So the path is also allowed to wander: its
//! heading takes a random turn in each of [`PIECES`] pieces of the run, of a variance that the track
//! itself tells (restricted likelihood). The variance is not pinned to its best value but averaged
//! over, weighted by the likelihood, and the larger sigma of the two, with and without wandering, is
//! reported. Blocks of a jackknife would not do: wandering is correlated over the whole run.

use core::f64::consts::{PI, TAU};
use core::fmt;

use crate::advice::Advice;
use crate::geometry::{Geometry, GeometryError, Turns};
use crate::mixed_model::{MixedModel, Solution};
use crate::path::{Pose, dead_reckon};
use crate::wheel_weight::{Angle, Contribution, SIGMAS_95, Source, WheelWeight};

/// Pieces of a run in which its heading may take a turn of its own.
const PIECES: usize = 20;

/// One measurement of where the robot was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackSample {
    /// When \[s\], on the clock of the wheel angles.
    pub t_s: f64,
    /// Measured x in a fixed frame \[m\].
    pub x_m: f64,
    /// Measured y in a fixed frame \[m\].
    pub y_m: f64,
    /// Measured heading \[rad\], wrapped or not, if there is one.
    pub heading_rad: Option<f64>,
}

/// A measured track.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// In order of time.
    pub samples: Vec<TrackSample>,
    /// Noise of x and of y, one sigma \[m\].
    pub position_sigma_m: f64,
    /// Noise of the heading, one sigma \[rad\]; ignored if no sample has a heading.
    pub heading_sigma_rad: f64,
}

impl Track {
    /// A track whose noise, where it is not stated, is estimated from how the samples scatter.
    ///
    /// Estimate: second differences x(i) - 2 x(i+1) + x(i+2), which a smooth motion leaves near
    /// zero, have sqrt(6) times the noise of a sample.
    pub fn new(
        samples: Vec<TrackSample>,
        position_sigma_m: Option<f64>,
        heading_sigma_rad: Option<f64>,
    ) -> Self {
        let position_sigma_m = position_sigma_m.unwrap_or_else(|| {
            let axis = |read: fn(&TrackSample) -> f64| samples.iter().map(read).collect::<Vec<_>>();
            scatter(&axis(|it| it.x_m)).hypot(scatter(&axis(|it| it.y_m))) / 2_f64.sqrt()
        });
        let heading_sigma_rad = heading_sigma_rad.unwrap_or_else(|| {
            let mut headings: Vec<_> = samples.iter().filter_map(|it| it.heading_rad).collect();
            for i in 1..headings.len() {
                headings[i] = headings[i - 1] + wrap(headings[i] - headings[i - 1]);
            }
            scatter(&headings)
        });
        Self {
            samples,
            // A track without any noise is one made by a formula; a micrometre keeps it solvable.
            position_sigma_m: position_sigma_m.max(1e-6),
            heading_sigma_rad: heading_sigma_rad.max(1e-6),
        }
    }
}

/// Cumulative wheel angles at one time, any start value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelAngles {
    /// When \[s\].
    pub t_s: f64,
    /// How far the wheels have turned.
    pub turns: Turns,
}

/// What to fit besides W_T and the start pose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FitOptions {
    /// A constant delay of the track's clock behind the wheels' clock.
    pub delay: bool,
}

/// A value and its standard uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard uncertainty.
    pub sigma: f64,
}

/// What a track says.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackFit {
    /// W_T, with everything in its sigma; its alpha is that of the whole run.
    pub wheel_weight: WheelWeight,
    /// Pose at the first sample, fitted.
    pub start: Pose,
    /// Pose at the last sample as fitted, in the frame of the start: `y_m` is the lateral offset.
    pub end: Pose,
    /// Standard uncertainty of the end's `y_m` \[m\].
    pub end_offset_sigma_m: f64,
    /// Standard uncertainty of the end's heading \[rad\].
    pub end_heading_sigma_rad: f64,
    /// Delay of the track \[s\], if it was fitted.
    pub delay_s: Option<Estimate>,
    /// Mean of both wheel radii relative to what the nominal left radius and W_T make it.
    pub scale: Estimate,
    /// Sigma of W_T if the track's noise were all there is.
    pub white_sigma: f64,
    /// Sigma of W_T with the robot's own wandering, which integrates.
    pub wander_sigma: f64,
    /// Root mean square of the position residuals without wandering, each axis \[m\].
    pub position_rms_m: f64,
    /// Root mean square of the heading residuals \[rad\]; zero without headings.
    pub heading_rms_rad: f64,
    /// Root mean square of the residuals in units of their sigmas; 1 if the noise is as stated.
    pub chi: f64,
    /// The fitted pose at each sample, in the frame of the track.
    pub fitted: Vec<Pose>,
}

/// Fits W_T to a track and the wheel angles of the same run.
///
/// Samples outside the time of the wheel angles are left out.
pub fn fit_track(
    track: &Track,
    wheel_angles: &[WheelAngles],
    geometry: &Geometry,
    options: FitOptions,
) -> Result<TrackFit, TrackFitError> {
    validate(track, wheel_angles, geometry)?;
    let run = Run::new(track, wheel_angles, geometry, options)?;
    let beta = run.least_squares()?;
    run.judge(beta)
}

/// All unknowns but the wandering.
#[derive(Clone, Copy)]
struct Beta {
    start: Pose,
    wheel_weight: f64,
    delay_s: f64,
    scale: f64,
}

/// Places of the unknowns in a row: x0, y0, theta0, W_T, the scale, then those asked for.
const START: usize = 3;
const WEIGHT: usize = 3;
const SCALE: usize = 4;

impl Beta {
    fn step(&mut self, options: FitOptions, by: &[f64]) {
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
struct Run<'a> {
    samples: Vec<TrackSample>,
    angles: &'a [WheelAngles],
    geometry: &'a Geometry,
    options: FitOptions,
    position_sigma_m: f64,
    heading_sigma_rad: f64,
}

/// One residual and its derivatives, ready for the normal equations.
struct Line {
    row: Vec<f64>,
    residual: f64,
    sigma: f64,
}

impl<'a> Run<'a> {
    fn new(
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
        // Counts are whole: each travel is off by a uniform part of Q, variance Q^2/12. The middle
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
        // A tenth of a radian of wheel says nothing of radii.
        if turns.phi_left_rad.abs() < 0.1 || turns.phi_right_rad.abs() < 0.1 {
            return Err(TrackFitError::NoTravel);
        }
        Ok(run)
    }

    /// Wheel angles at a time, held at the ends.
    fn turns_at(&self, t_s: f64) -> (usize, Turns) {
        let after = self.angles.partition_point(|angles| angles.t_s <= t_s);
        let after = after.clamp(1, self.angles.len() - 1);
        let (a, b) = (&self.angles[after - 1], &self.angles[after]);
        let share = ((t_s - a.t_s) / (b.t_s - a.t_s)).clamp(0.0, 1.0);
        (after - 1, a.turns.toward(b.turns, share))
    }

    /// How far the wheels turned from the first sample to the last.
    fn turns(&self) -> Turns {
        let [first, last] =
            [0, self.samples.len() - 1].map(|i| self.turns_at(self.samples[i].t_s).1);
        last.since(first)
    }

    /// Predicted poses at the samples, in the frame of the first.
    fn local(&self, wheel_weight: f64, delay_s: f64, scale: f64) -> Vec<Pose> {
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
                    geometry.wheel_radius_m * step.phi_left_rad,
                    geometry.wheel_radius_m * wheel_weight * step.phi_right_rad,
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

    /// Derivatives of the local poses by W_T, the scale and whatever else was asked for.
    fn shape_derivatives(&self, beta: &Beta) -> Vec<Vec<Pose>> {
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
            // Long enough that whole counts do not make the speed jump.
            let h = 0.02;
            difference(h, self.local(w, d + h, k), self.local(w, d - h, k));
        }
        all
    }

    /// The residual equations at `beta`: x, y and, where measured, heading of each sample.
    fn lines(&self, beta: &Beta, pieces: usize) -> Vec<Line> {
        let local = self.local(beta.wheel_weight, beta.delay_s, beta.scale);
        let derivatives = self.shape_derivatives(beta);
        let wandering = self.wandering(beta, &local, pieces);
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

    /// For each sample, what a turn of one radian in each piece of the run does to its pose.
    ///
    /// The turn is spread evenly over its piece; pieces are equal in wheel travel.
    fn wandering(&self, beta: &Beta, local: &[Pose], pieces: usize) -> Vec<Vec<Pose>> {
        let turns: Vec<_> =
            self.samples.iter().map(|it| self.turns_at(it.t_s - beta.delay_s).1).collect();
        let mut travelled = vec![0.0];
        for pair in turns.windows(2) {
            let step = pair[1].since(pair[0]);
            let so_far = travelled[travelled.len() - 1];
            travelled.push(so_far + step.phi_left_rad.abs() + step.phi_right_rad.abs());
        }
        let piece_rad = travelled[travelled.len() - 1] / pieces.max(1) as f64;
        let turned = |sample: usize, piece: usize| {
            (travelled[sample] / piece_rad - piece as f64).clamp(0.0, 1.0)
        };
        let world: Vec<_> = local.iter().map(|pose| beta.start.compose(*pose)).collect();
        let mut now = vec![Pose::ORIGIN; pieces];
        let mut all = vec![now.clone()];
        for i in 1..world.len() {
            let (dx_m, dy_m) = (world[i].x_m - world[i - 1].x_m, world[i].y_m - world[i - 1].y_m);
            for (piece, pose) in now.iter_mut().enumerate() {
                let heading_rad = turned(i, piece);
                let middle_rad = (heading_rad + pose.heading_rad) / 2.0;
                pose.x_m -= middle_rad * dy_m;
                pose.y_m += middle_rad * dx_m;
                pose.heading_rad = heading_rad;
            }
            all.push(now.clone());
        }
        all
    }

    fn unknowns(&self) -> usize {
        SCALE + 1 + usize::from(self.options.delay)
    }

    /// Where the track must start for equal wheels to fit it best: the turn that lays the predicted
    /// points on the measured ones (Procrustes).
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
    fn least_squares(&self) -> Result<Beta, TrackFitError> {
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
            // A hundredth of its own sigma is nothing.
            if step.values[WEIGHT].abs() < 0.01 * step.covariance[(WEIGHT, WEIGHT)].sqrt() {
                return Ok(beta);
            }
        }
        Err(TrackFitError::NotConverged)
    }

    /// From the least-squares solution to W_T with all its uncertainty.
    fn judge(&self, mut beta: Beta) -> Result<TrackFit, TrackFitError> {
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
        let lever =
            self.geometry.wheel_radius_m * turns.phi_right_rad / self.geometry.track_width_m;
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

    /// How much larger the noise is than stated, from second differences of the residuals, which
    /// wandering leaves alone; never below 1.
    fn noise_scale(&self, lines: &[Line]) -> f64 {
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

    /// The poses with the best wandering put in.
    fn fitted(&self, beta: &Beta, best: &Solution) -> Vec<Pose> {
        let mut moved = *beta;
        moved.step(self.options, best.values.as_slice());
        let local = self.local(moved.wheel_weight, moved.delay_s, moved.scale);
        let wandering = self.wandering(&moved, &local, PIECES);
        let turns = &best.values.as_slice()[self.unknowns()..];
        local
            .iter()
            .zip(wandering)
            .map(|(local, pieces)| {
                let mut pose = moved.start.compose(*local);
                for (piece, turn) in pieces.iter().zip(turns) {
                    pose.x_m += turn * piece.x_m;
                    pose.y_m += turn * piece.y_m;
                    pose.heading_rad += turn * piece.heading_rad;
                }
                pose
            })
            .collect()
    }

    /// Sigmas of offset and heading at the end relative to the start pose, whose own shifts and
    /// turns move the line along with the end.
    fn end_sigmas(&self, beta: &Beta, best: &Solution, piece_variance: f64) -> (f64, f64) {
        let local = self.local(beta.wheel_weight, beta.delay_s, beta.scale);
        let wandering = self.wandering(beta, &local, PIECES);
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
        // How the heading wandered inside the first piece is not resolved: a third of the variance of
        // its turn stays in the start heading, and turns the whole run about the start.
        let unresolved_rad = (piece_variance / 3.0).sqrt();
        let reach_m = local[last].x_m;
        (sigma(offset).hypot(reach_m * unresolved_rad), sigma(heading).hypot(unresolved_rad))
    }

    /// W_T with its budget: the track's noise, wandering, and the tolerance of b.
    fn wheel_weight(&self, value: f64, white: f64, sigma: f64, scale: f64) -> WheelWeight {
        let turns = self.turns();
        let radius_m = self.geometry.wheel_radius_m * scale;
        let (left_m, right_m) = (radius_m * turns.phi_left_rad, radius_m * turns.phi_right_rad);
        let track_m = self.geometry.track_width_m;
        let alpha_rad = (left_m - value * right_m) / track_m;
        // What the track shows is the turn b alpha and the scale; a wrong b turns into W_T by its share.
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

/// An estimate averaged over the variance of the wandering.
struct Averaged {
    value: f64,
    sigma: f64,
    /// The likeliest of the solutions, and the variance of a piece's turn in it.
    best: Solution,
    best_variance: f64,
}

/// Averages one unknown over the variance of the random ones, weighted by their likelihood.
///
/// `heading_sigma_rad` is the sigma of the whole run's turn without wandering. Wandering is taken to
/// be between 1 and 128 times that, every factor of sqrt 2 as likely beforehand. Less could not be
/// told from none by one track, so a robot that does not wander at all gets a cautious sigma.
fn average_over_variance(
    model: &MixedModel,
    heading_sigma_rad: f64,
    place: usize,
) -> Option<Averaged> {
    // A factor of sqrt 2 in sigma is one of 2 in variance.
    let variance =
        |place: usize| heading_sigma_rad.powi(2) * 2_f64.powi(place as i32) / PIECES as f64;
    let mut solutions = Vec::new();
    for place in 0..=14 {
        solutions.push(model.solve(variance(place))?);
    }
    let best = (0..solutions.len())
        .max_by(|&a, &b| solutions[a].log_likelihood.total_cmp(&solutions[b].log_likelihood))?;
    let top = solutions[best].log_likelihood;
    let weights: Vec<_> = solutions.iter().map(|it| (it.log_likelihood - top).exp()).collect();
    let total: f64 = weights.iter().sum();
    // Each variance's answer: its weight, value and sigma.
    let answers: Vec<_> = solutions
        .iter()
        .zip(weights)
        .map(|(it, weight)| {
            (weight / total, it.values[place], it.covariance[(place, place)].sqrt())
        })
        .collect();
    let value: f64 = answers.iter().map(|(weight, value, _)| weight * value).sum();
    let widest =
        answers.iter().fold(0.0_f64, |most, (_, it, sigma)| most.max(sigma + (it - value).abs()));

    // The half width outside which 5 % of the mixture lie, by halving.
    let outside = |half: f64| -> f64 {
        let tails = |it: f64, sigma: f64| {
            normal_tail((half - it + value) / sigma) + normal_tail((half + it - value) / sigma)
        };
        answers.iter().map(|(weight, it, sigma)| weight * tails(*it, *sigma)).sum()
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

/// Probability of a normal deviate above `x`: Abramowitz and Stegun 26.2.17, good to 1e-7.
fn normal_tail(x: f64) -> f64 {
    if x < 0.0 {
        return 1.0 - normal_tail(-x);
    }
    let t = 1.0 / (1.0 + 0.231_641_9 * x);
    let series = [0.319_381_530, -0.356_563_782, 1.781_477_937, -1.821_255_978, 1.330_274_429];
    let polynomial = series.iter().rev().fold(0.0, |sum, c| t * (c + sum));
    (-x * x / 2.0).exp() / TAU.sqrt() * polynomial
}

/// Residuals in figures.
struct Residuals {
    position_rms_m: f64,
    heading_rms_rad: f64,
    chi: f64,
}

impl Residuals {
    fn of(lines: &[Line]) -> Self {
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

/// Noise of one sample, from second differences.
fn scatter(values: &[f64]) -> f64 {
    noise_of(second_differences(values).collect())
}

fn second_differences(values: &[f64]) -> impl Iterator<Item = f64> {
    values.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs())
}

/// The noise that makes such second differences, by their median; 0 if there are none.
fn noise_of(mut differences: Vec<f64>) -> f64 {
    differences.sort_by(f64::total_cmp);
    // The median of |N(0, 1)| is 0.6745.
    differences.get(differences.len() / 2).map_or(0.0, |middle| middle / 0.6745 / 6_f64.sqrt())
}

/// An angle brought to -pi..pi.
fn wrap(angle_rad: f64) -> f64 {
    (angle_rad + PI).rem_euclid(TAU) - PI
}

fn validate(
    track: &Track,
    angles: &[WheelAngles],
    geometry: &Geometry,
) -> Result<(), TrackFitError> {
    geometry.validate()?;
    for (name, value) in [
        ("the noise of the position", track.position_sigma_m),
        ("the noise of the heading", track.heading_sigma_rad),
    ] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(TrackFitError::BadNumber { name, value });
        }
    }
    let samples = track.samples.iter().flat_map(|it| {
        let heading_rad = it.heading_rad.unwrap_or(0.0);
        [("time", it.t_s), ("x", it.x_m), ("y", it.y_m), ("heading", heading_rad)]
    });
    let wheels = angles.iter().flat_map(|it| {
        [("time", it.t_s), ("wheel angle", it.turns.phi_left_rad + it.turns.phi_right_rad)]
    });
    for (name, value) in samples.chain(wheels) {
        if !value.is_finite() {
            return Err(TrackFitError::BadNumber { name, value });
        }
    }
    if let Some(pair) = track.samples.windows(2).find(|pair| pair[1].t_s <= pair[0].t_s) {
        return Err(TrackFitError::TimeNotIncreasing { name: "track", t_s: pair[1].t_s });
    }
    if let Some(pair) = angles.windows(2).find(|pair| pair[1].t_s <= pair[0].t_s) {
        return Err(TrackFitError::TimeNotIncreasing { name: "wheel angles", t_s: pair[1].t_s });
    }
    match angles.len() {
        0 | 1 => Err(TrackFitError::NoTravel),
        _ => Ok(()),
    }
}

/// Why a track cannot be fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TrackFitError {
    /// The nominal robot is unphysical.
    Geometry(GeometryError),
    /// Too few samples for the unknowns.
    TooFewSamples {
        /// How many there are within the time of the wheel angles.
        found: usize,
        /// How many it takes.
        needed: usize,
    },
    /// A number is not finite, or a sigma not above zero.
    BadNumber {
        /// Which.
        name: &'static str,
        /// The value refused.
        value: f64,
    },
    /// Times do not increase.
    TimeNotIncreasing {
        /// In what.
        name: &'static str,
        /// At which time \[s\].
        t_s: f64,
    },
    /// The wheels did not turn while the track was measured.
    NoTravel,
    /// The fit found no minimum.
    NotConverged,
}

impl fmt::Display for TrackFitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Geometry(error) => error.fmt(f),
            Self::TooFewSamples { found, needed } => write!(
                f,
                "only {found} samples of the track lie within the run, it takes {needed}: \
                 check that both use the same clock"
            ),
            Self::BadNumber { name, value } => write!(f, "{name} cannot be {value}"),
            Self::TimeNotIncreasing { name, t_s } => {
                write!(f, "the time of the {name} does not increase at {t_s} s")
            }
            Self::NoTravel => write!(f, "the wheels did not turn while the track was measured"),
            Self::NotConverged => write!(
                f,
                "no wheel weight explains this track: check its clock, its unit and its axes \
                 (x forward, y left)"
            ),
        }
    }
}

impl core::error::Error for TrackFitError {}

impl From<GeometryError> for TrackFitError {
    fn from(error: GeometryError) -> Self {
        Self::Geometry(error)
    }
}

#[cfg(test)]
mod tests;
