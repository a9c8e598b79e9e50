//! By what the error might depend on: the stretches grouped by each regime, and the error of each group.

use core::f64::consts::{FRAC_PI_2, TAU};

use super::rms::Rms;
use super::stretch::{Component, Drift, Stretch, drift, stretches, tracks};
use crate::effect::composition::Term;
use crate::numeric::distributions::chi_squared;
use crate::recording::campaign::{Prepared, PreparedRun};
use crate::recording::motion::Step;
use crate::recording::odometry_noise::OdometryNoise;
use crate::recording::run_kind::RunKind;

/// Slower than this is rest \[m/s, of a rim\].
const MOVING_MPS: f64 = 0.01;
/// A rim that gains this share of the run's fastest speed in a second is on a ramp, and at least
/// [`RAMP_MIN_MPS2`].
const RAMP_SHARE_PER_S: f64 = 0.15;
/// What the smoothing of counted wheel angles makes of cruising \[m/s^2\].
const RAMP_MIN_MPS2: f64 = 0.03;
/// Radius above which a path counts as straight \[m\], below which the robot turns on the spot.
const STRAIGHT_RADIUS_M: f64 = 3.0;
const SPIN_RADIUS_M: f64 = 0.05;
/// Noise alone puts a group beyond it this often, all groups of a grouping together.
const FALSE_ALARM: f64 = 0.01;

/// A systematic error of so many standard errors is none of chance: three components of some thirty groups
/// reach it once in two hundred campaigns.
const DRIFT_SIGMAS: f64 = 4.0;

/// The errors grouped by one thing that they might depend on.
#[derive(Clone, Debug, PartialEq)]
pub struct Grouping {
    /// What it is.
    pub regime: Regime,
    /// Its values.
    pub groups: Vec<RegimeError>,
}

/// What the error might depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Regime {
    /// The kind of run.
    RunKind,
    /// Straight, in an arc, on the spot.
    Path,
    /// Speeding up or cruising.
    RampOrCruise,
    /// Forward or backward.
    TravelDirection,
    /// To the left or to the right.
    TurnDirection,
    /// Speed of the faster rim.
    Speed,
    /// Heading.
    Heading,
    /// Angle of the left wheel.
    LeftWheelAngle,
    /// Angle of the right wheel.
    RightWheelAngle,
}

/// A kind of stretches, within a regime.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Label {
    /// In runs of this kind.
    Kind(RunKind),
    /// Straight.
    Straight,
    /// In an arc.
    Arc,
    /// On the spot.
    OnTheSpot,
    /// Speeding up or slowing down.
    Ramp,
    /// At a speed that stays.
    Cruise,
    /// Forward.
    Forward,
    /// Backward.
    Backward,
    /// To the left.
    Left,
    /// To the right.
    Right,
    /// At speeds between these \[m/s\]; `None` without a bound.
    Speed {
        /// Above this.
        above: Option<f64>,
        /// Up to this.
        to: Option<f64>,
    },
    /// At headings nearest to this one \[deg\].
    Facing(u16),
    /// Within a quarter turn from this angle on \[deg\].
    Quadrant(u16),
}

/// The error over all stretches of one kind: one group of a [`Grouping`].
#[derive(Clone, Debug, PartialEq)]
pub struct RegimeError {
    /// Of which kind.
    pub label: Label,
    /// How many runs have such stretches.
    pub runs: usize,
    /// How many there are.
    pub stretches: usize,
    /// How long they are on average, in rolling of the rims \[m\].
    pub rolled_m: f64,
    /// Distance between the predicted and the measured move, over one stretch \[m\].
    pub position_m: Rms,
    /// The same of the turn \[rad\].
    pub heading_rad: Rms,
    /// Root of the mean square in units of noise: 1 is noise.
    pub chi: f64,
    /// The stretches scatter more than noise does.
    pub scattered: bool,
    /// More than noise explains: in all, or in what is the same in all of them.
    pub beyond_noise: bool,
    /// What is the same in all of them: ahead, left, turned.
    pub drifts: [Drift; 3],
}

impl RegimeError {
    /// The systematic error that stands out most.
    pub fn main_drift(&self) -> Drift {
        let first = self.drifts[0];
        self.drifts.iter().copied().fold(first, |a, b| if b.sigmas() > a.sigmas() { b } else { a })
    }
}

/// Which label a step has, if any.
type Sorter<'a> = Box<dyn Fn(&PreparedRun, &Step) -> Option<usize> + 'a>;

/// The labels of a regime, and which one a step has.
struct Labels<'a> {
    regime: Regime,
    labels: Vec<Label>,
    of: Sorter<'a>,
}

/// The stretches grouped by every regime.
pub(super) fn groupings(
    prepared: &Prepared,
    terms: &[Term<'_>],
    noise: &OdometryNoise,
) -> Vec<Grouping> {
    let tracks = tracks(prepared, terms);
    labels(prepared)
        .into_iter()
        .filter_map(|labels| {
            let mut found: Vec<Vec<Stretch>> = vec![Vec::new(); labels.labels.len()];
            for (index, (run, track)) in prepared.runs.iter().zip(&tracks).enumerate() {
                let label = |k: usize| (labels.of)(run, &run.motion.steps[k]);
                for (label, stretch) in stretches(index, run, track, noise, label) {
                    found[label].push(stretch);
                }
            }
            let there = found.iter().filter(|stretches| !stretches.is_empty()).count();
            let groups: Vec<RegimeError> = labels
                .labels
                .into_iter()
                .zip(&found)
                .filter(|(_, stretches)| !stretches.is_empty())
                .map(|(label, stretches)| group(label, stretches, there))
                .collect();
            // A single group shows no dependence; the kinds of runs are kept all the same.
            let tells =
                groups.len() > 1 || (labels.regime == Regime::RunKind && !groups.is_empty());
            tells.then_some(Grouping { regime: labels.regime, groups })
        })
        .collect()
}

fn group(label: Label, found: &[Stretch], groups: usize) -> RegimeError {
    let n = found.len() as f64;
    let mean = |of: &dyn Fn(&Stretch) -> f64| found.iter().map(of).sum::<f64>() / n;
    let rms = |parts: &[usize]| {
        let sum = |of: &dyn Fn(&Stretch, usize) -> f64| {
            mean(&|stretch| parts.iter().map(|i| of(stretch, *i).powi(2)).sum()).sqrt()
        };
        let noise = sum(&|stretch, i| stretch.sigma[i]);
        // The mean of n chi squares of one degree scatters by sqrt(2/n); 2.33 sigma are 99 %.
        let high = 1.0 + 2.33 * (2.0 / (n * parts.len() as f64)).sqrt();
        Rms { rms: sum(&|stretch, i| stretch.error[i]), noise, noise_high: noise * high.sqrt() }
    };
    let squares: f64 = found
        .iter()
        .flat_map(|stretch| (0..3).map(|i| (stretch.error[i] / stretch.sigma[i]).powi(2)))
        .sum();
    let all: Vec<&Stretch> = found.iter().collect();
    let mut runs: Vec<usize> = found.iter().map(|stretch| stretch.run).collect();
    runs.sort_unstable();
    runs.dedup();
    let chi = (squares / (3.0 * n)).sqrt();
    // Noise is known to a few per cent only: what exceeds it by less is not held against the model.
    let excess = squares / NOISE_KNOWN_TO.powi(2);
    let drifts = Component::ALL.map(|component| drift(&all, component));
    let steady = drifts.iter().any(|drift| drift.sigmas() > DRIFT_SIGMAS);
    let scattered = chi_squared(3 * found.len(), excess) * (groups as f64) < FALSE_ALARM;
    RegimeError {
        label,
        runs: runs.len(),
        stretches: found.len(),
        rolled_m: mean(&|stretch| stretch.rolled_m),
        position_m: rms(&[0, 1]),
        heading_rad: rms(&[2]),
        chi,
        scattered,
        beyond_noise: scattered || steady,
        drifts,
    }
}

/// A factor that the noise's sigma may be off by.
const NOISE_KNOWN_TO: f64 = 1.1;

fn labels(prepared: &Prepared) -> Vec<Labels<'_>> {
    vec![
        run_kind(prepared),
        path(),
        ramp_or_cruise(prepared),
        travel_direction(),
        turn_direction(),
        speed(prepared),
        heading(),
        wheel_angle(Regime::LeftWheelAngle, |step| step.phi_rad.left + step.dphi_rad.left / 2.0),
        wheel_angle(Regime::RightWheelAngle, |step| step.phi_rad.right + step.dphi_rad.right / 2.0),
    ]
}

fn run_kind<'a>(prepared: &Prepared) -> Labels<'a> {
    let mut kinds: Vec<_> = prepared.runs.iter().map(|run| run.kind).collect();
    kinds.sort_unstable();
    kinds.dedup();
    Labels {
        regime: Regime::RunKind,
        labels: kinds.iter().copied().map(Label::Kind).collect(),
        of: Box::new(move |run, step| {
            moving(step).then(|| kinds.iter().position(|kind| *kind == run.kind)).flatten()
        }),
    }
}

fn path<'a>() -> Labels<'a> {
    Labels {
        regime: Regime::Path,
        labels: vec![Label::Straight, Label::Arc, Label::OnTheSpot],
        of: Box::new(|_, step| moving(step).then(|| path_of(step))),
    }
}

fn ramp_or_cruise<'a>(prepared: &Prepared) -> Labels<'a> {
    let fastest = prepared
        .runs
        .iter()
        .map(|run| run.motion.steps.iter().map(rim_mps).fold(0.0, f64::max))
        .fold(0.0, f64::max);
    let ramp_mps2 = RAMP_MIN_MPS2.max(RAMP_SHARE_PER_S * fastest);
    Labels {
        regime: Regime::RampOrCruise,
        labels: vec![Label::Ramp, Label::Cruise],
        of: Box::new(move |_, step| {
            let accel = step.wheel_accel_mps2.map(f64::abs);
            let ramp = accel.left.max(accel.right) > ramp_mps2;
            moving(step).then_some(usize::from(!ramp))
        }),
    }
}

fn travel_direction<'a>() -> Labels<'a> {
    Labels {
        regime: Regime::TravelDirection,
        labels: vec![Label::Forward, Label::Backward],
        of: Box::new(|_, step| {
            let on_the_spot = path_of(step) == 2;
            (moving(step) && !on_the_spot).then(|| usize::from(step.speed_mps() < 0.0))
        }),
    }
}

fn turn_direction<'a>() -> Labels<'a> {
    Labels {
        regime: Regime::TurnDirection,
        labels: vec![Label::Left, Label::Right],
        of: Box::new(|_, step| {
            let turning = path_of(step) > 0;
            (moving(step) && turning).then(|| usize::from(step.turn_rate_rad_s() < 0.0))
        }),
    }
}

fn speed<'a>(prepared: &Prepared) -> Labels<'a> {
    let edges = quantile_edges(prepared);
    Labels {
        regime: Regime::Speed,
        labels: speed_labels(&edges),
        of: Box::new(move |_, step| {
            let speed = rim_mps(step);
            moving(step).then(|| edges.iter().filter(|edge| speed > **edge).count())
        }),
    }
}

fn heading<'a>() -> Labels<'a> {
    let facing = |angle_rad: f64| {
        ((angle_rad + FRAC_PI_2 / 2.0).rem_euclid(TAU) / FRAC_PI_2).floor().min(3.0) as usize
    };
    Labels {
        regime: Regime::Heading,
        labels: [0, 90, 180, 270].map(Label::Facing).to_vec(),
        of: Box::new(move |_, step| {
            (moving(step) && path_of(step) < 2).then(|| facing(step.heading_rad))
        }),
    }
}

fn wheel_angle<'a>(regime: Regime, angle_rad: fn(&Step) -> f64) -> Labels<'a> {
    let quadrant =
        |angle_rad: f64| (angle_rad.rem_euclid(TAU) / (TAU / 4.0)).floor().min(3.0) as usize;
    Labels {
        regime,
        labels: [0, 90, 180, 270].map(Label::Quadrant).to_vec(),
        of: Box::new(move |_, step| moving(step).then(|| quadrant(angle_rad(step)))),
    }
}

/// Speed of the faster rim \[m/s\].
pub(super) fn rim_mps(step: &Step) -> f64 {
    let speed = step.wheel_speed_mps.map(f64::abs);
    speed.left.max(speed.right)
}

pub(super) fn moving(step: &Step) -> bool {
    rim_mps(step) > MOVING_MPS
}

/// Straight 0, arc 1, on the spot 2.
fn path_of(step: &Step) -> usize {
    let (speed, rate) = (step.speed_mps().abs(), step.turn_rate_rad_s().abs());
    if rate * STRAIGHT_RADIUS_M <= speed {
        0
    } else if rate * SPIN_RADIUS_M >= speed {
        2
    } else {
        1
    }
}

/// Speeds that part the rolling of all runs in three, where they differ.
fn quantile_edges(prepared: &Prepared) -> Vec<f64> {
    let steps = prepared.runs.iter().flat_map(|run| &run.motion.steps);
    let mut speeds: Vec<f64> = steps.filter(|step| moving(step)).map(rim_mps).collect();
    if speeds.is_empty() {
        return Vec::new();
    }
    speeds.sort_by(f64::total_cmp);
    let mut edges =
        [0.33, 0.67].map(|share| speeds[(share * speeds.len() as f64) as usize]).to_vec();
    // Speeds that differ by less than a quarter are one speed.
    edges.dedup_by(|b, a| *b < 1.25 * *a);
    edges
}

fn speed_labels(edges: &[f64]) -> Vec<Label> {
    let between = |k: usize| Label::Speed {
        above: k.checked_sub(1).map(|below| edges[below]),
        to: edges.get(k).copied(),
    };
    (0..=edges.len()).map(between).collect()
}
