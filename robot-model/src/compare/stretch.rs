//! By how much does the move between two measured poses differ from the predicted one, and by how much would noise
//! alone make it differ?
//!
//! Over a stretch of duration t on which the rims roll d and the robot moves by (c_x, c_y), with the noise
//! of [`OdometryNoise`]:
//!
//! ```text
//! var(turn)  = 2 sigma_t^2 + 2 w_t^2 (1 - e^(-t/T)) + k_t^2 d                           (1)
//! var(ahead) = 2 sigma_p^2 + 2 w_p^2 (1 - e^(-t/T)) + k_s^2 d + c_y^2 u                 (2)
//! var(left)  = the same with c_x;    u = sigma_t^2 + w_t^2 + k_t^2 d / 3                (3)
//! ```
//!
//! u is the variance of the heading along the stretch: that of the heading measured at its start, and a third of the
//! random walk since, as is the mean over the path.

use crate::effect::composition::Term;
use crate::estimation::predict::{PredictedTrack, open_loop_as_seen};
use crate::kinematics::pose::Pose;
use crate::numeric::angle::wrap;
use crate::numeric::parallel;
use crate::recording::campaign::{Prepared, PreparedRun};
use crate::recording::motion::Step;
use crate::recording::odometry_noise::OdometryNoise;

/// A stretch is cut after so much rolling \[m\]: long enough to stand out of the camera's noise.
const ROLLED_MAX_M: f64 = 0.5;
/// An interval with more rolling than [`ROLLED_MAX_M`] has a label if at least this share of its rolling has it.
const LABEL_SHARE: f64 = 0.7;
/// Stretches with less rolling tell nothing \[m\].
const ROLLED_MIN_M: f64 = 0.01;

/// One stretch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    pub run: usize,
    /// Mean of both wheels' rolling \[m\].
    pub rolled_m: f64,
    /// Ahead and left \[m\], turned \[rad\]: measured less predicted.
    pub error: [f64; 3],
    /// One sigma of noise in each.
    pub sigma: [f64; 3],
}

/// What a systematic error is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    /// Along the path, too far is positive.
    Ahead,
    /// Sideways, left is positive.
    Left,
    /// The heading, counter-clockwise is positive.
    Turn,
}

impl Component {
    pub(super) const ALL: [Self; 3] = [Self::Ahead, Self::Left, Self::Turn];
}

/// What is the same in all stretches, per metre that the rims roll.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    /// Of what.
    pub component: Component,
    /// \[m/m\] or \[rad/m\], measured less predicted.
    pub per_m: f64,
    /// Its standard error, by noise or by the scatter between runs, whichever is greater.
    pub sigma: f64,
}

impl Drift {
    /// How many standard errors it is from zero.
    pub fn sigmas(&self) -> f64 {
        if self.sigma > 0.0 { self.per_m.abs() / self.sigma } else { 0.0 }
    }
}

/// The predicted track of each run, from a start with the heading that was measured.
pub(super) fn tracks(prepared: &Prepared, terms: &[Term<'_>]) -> Vec<PredictedTrack> {
    parallel::map(&prepared.runs, |run| {
        open_loop_as_seen(&run.motion, &run.recording.measured_poses, terms)
    })
}

/// The stretches of a run on each of which `label` stays the same, with that label.
///
/// `label` is called for each step; steps without a label are in no stretch.
pub(super) fn stretches(
    index: usize,
    run: &PreparedRun,
    track: &PredictedTrack,
    noise: &OdometryNoise,
    label: impl Fn(usize) -> Option<usize>,
) -> Vec<(usize, Stretch)> {
    let steps = &run.motion.steps;
    let rolled: Vec<f64> = core::iter::once(0.0)
        .chain(steps.iter().scan(0.0, |sum, step| {
            *sum += step.rolled_m();
            Some(*sum)
        }))
        .collect();
    let whole: Vec<usize> = (0..track.measured.len())
        .filter(|k| {
            track.measured[*k].position_m.is_some() && track.measured[*k].heading_rad.is_some()
        })
        .collect();
    let mut found = Vec::new();
    let mut open: Option<(usize, usize)> = None;
    let close = |from: usize, to: usize, label: usize, found: &mut Vec<_>| {
        if let Some(stretch) = between(index, steps, track, &rolled, noise, from, to) {
            found.push((label, stretch));
        }
    };
    for pair in whole.windows(2) {
        let (from, to) = (track.step[pair[0]], track.step[pair[1]]);
        // If poses are close, the interval has the label of the step in its middle. A longer one may have several:
        // poses at its ends tell nothing about the angle of a wheel that went round between them.
        let here = label((from + to).div_ceil(2).min(steps.len() - 1)).filter(|name| {
            let all_m = rolled[to] - rolled[from];
            let same = (from..to).filter(|k| label(*k) == Some(*name));
            all_m <= ROLLED_MAX_M
                || same.map(|k| steps[k].rolled_m()).sum::<f64>() >= LABEL_SHARE * all_m
        });
        if let Some((begin, name)) = open {
            let long = rolled[track.step[pair[0]]] - rolled[track.step[begin]] >= ROLLED_MAX_M;
            if here != Some(name) || long {
                close(begin, pair[0], name, &mut found);
                open = None;
            }
        }
        if open.is_none() {
            open = here.map(|name| (pair[0], name));
        }
    }
    if let (Some((begin, name)), Some(end)) = (open, whole.last()) {
        close(begin, *end, name, &mut found);
    }
    found
}

fn between(
    run: usize,
    steps: &[Step],
    track: &PredictedTrack,
    rolled: &[f64],
    noise: &OdometryNoise,
    from: usize,
    to: usize,
) -> Option<Stretch> {
    let rolled_m = rolled[track.step[to]] - rolled[track.step[from]];
    if to <= from || rolled_m < ROLLED_MIN_M {
        return None;
    }
    let pose = |k: usize| {
        let [x_m, y_m] = track.measured[k].position_m?;
        Some(Pose::new(x_m, y_m, track.measured[k].heading_rad?))
    };
    let measured = pose(to)?.seen_from(pose(from)?);
    let predicted = track.predicted[to].seen_from(track.predicted[from]);
    let t_s = track.measured[to].t_s - track.measured[from].t_s;
    let fading = 2.0 * (1.0 - noise.wobble_fade(t_s));
    let walk = noise.heading_variance_rad2(rolled_m);
    let heading = noise.heading_sigma_rad.powi(2) + noise.heading_wobble_rad.powi(2);
    // A clock offset shows where the speeds at both ends differ; a heading offset turns the whole stretch.
    let [begin, end] = [from, to].map(|k| &steps[track.step[k]]);
    let late_var = noise.clock_offset_s.powi(2);
    let faster_mps = end.speed_mps() - begin.speed_mps();
    let turns_faster_rad_s = end.turn_rate_rad_s() - begin.turn_rate_rad_s();
    let position_var = 2.0 * noise.position_sigma_m.powi(2)
        + fading * noise.position_wobble_m.powi(2)
        + noise.travel_variance_m2(rolled_m);
    let lever = heading + noise.heading_offset_rad.powi(2) + walk / 3.0;
    let turn_var = 2.0 * noise.heading_sigma_rad.powi(2)
        + fading * noise.heading_wobble_rad.powi(2)
        + walk
        + late_var * turns_faster_rad_s.powi(2);
    let along_var = position_var + late_var * faster_mps.powi(2);
    Some(Stretch {
        run,
        rolled_m,
        error: [
            measured.x_m - predicted.x_m,
            measured.y_m - predicted.y_m,
            wrap(measured.heading_rad - predicted.heading_rad),
        ],
        sigma: [
            (along_var + predicted.y_m.powi(2) * lever).sqrt(),
            (position_var + predicted.x_m.powi(2) * lever).sqrt(),
            turn_var.sqrt(),
        ],
    })
}

/// What is the same in all of these stretches.
pub(super) fn drift(stretches: &[&Stretch], component: Component) -> Drift {
    let i = component as usize;
    // The weight of each stretch is its information: the move is in proportion to the rolling.
    let weight = |stretch: &Stretch| stretch.rolled_m / stretch.sigma[i].powi(2);
    let total: f64 = stretches.iter().map(|stretch| weight(stretch) * stretch.rolled_m).sum();
    if total <= 0.0 {
        return Drift { component, per_m: 0.0, sigma: 0.0 };
    }
    let per_m =
        stretches.iter().map(|stretch| weight(stretch) * stretch.error[i]).sum::<f64>() / total;
    let mut runs: std::collections::BTreeMap<usize, f64> = Default::default();
    for stretch in stretches {
        *runs.entry(stretch.run).or_default() +=
            weight(stretch) * (stretch.error[i] - per_m * stretch.rolled_m);
    }
    let scatter: f64 = runs.values().map(|sum| sum * sum).sum();
    // The mean uses up one degree of freedom; with a single run only its noise is known.
    let count = runs.len() as f64;
    let between = if count > 1.0 { scatter * count / (count - 1.0) } else { 0.0 };
    Drift { component, per_m, sigma: total.max(between).sqrt() / total }
}
