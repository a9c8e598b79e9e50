//! In which regimes is the error beyond noise? Run kind, path, speed, heading and others, each with its cells.

use core::f64::consts::{FRAC_PI_2, TAU};

use serde::Serialize;

use super::rms::Rms;
use super::stretch::{Aspect, Drift, Stretch, drift, stretches, tracks};
use crate::effect::composition::Term;
use crate::estimation::odometry_noise::OdometryNoise;
use crate::numeric::distributions::chi_squared;
use crate::recording::campaign::{Prepared, PreparedRun};
use crate::recording::motion::Step;

/// A rim slower than this is at rest \[m/s\].
const MOVING_MPS: f64 = 0.01;
/// A rim that gains this share of the run's fastest speed in a second is on a ramp, and at least
/// [`RAMP_MIN_MPS2`].
const RAMP_SHARE_PER_S: f64 = 0.15;
/// Acceleration at cruise that smoothed counts may show \[m/s^2\].
const RAMP_MIN_MPS2: f64 = 0.03;
/// Radius above which a path counts as straight \[m\], below which the robot turns on the spot.
const STRAIGHT_RADIUS_M: f64 = 3.0;
const SPIN_RADIUS_M: f64 = 0.05;
/// Probability that noise alone puts any cell of a question beyond noise.
const FALSE_ALARM: f64 = 0.01;

/// A systematic error of this many standard errors is not chance: with three aspects of some thirty cells,
/// chance reaches it in one of two hundred campaigns.
const DRIFT_SIGMAS: f64 = 4.0;

/// One thing that the error might depend on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Question {
    /// Its name: "run kind", "speed".
    pub name: &'static str,
    /// Its values.
    pub cells: Vec<Cell>,
}

/// All stretches of one kind.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cell {
    /// Its label: "spin", "0.1 to 0.2 m/s".
    pub name: String,
    /// How many runs have such stretches.
    pub runs: usize,
    /// How many stretches there are.
    pub stretches: usize,
    /// Mean length, in rolling of the rims \[m\].
    pub rolled_m: f64,
    /// Distance between the predicted and the measured move, over one stretch \[m\].
    pub position_m: Rms,
    /// The same of the turn \[rad\].
    pub heading_rad: Rms,
    /// Root of the mean square in units of noise: 1 is noise.
    pub chi: f64,
    /// The stretches scatter more than noise does.
    pub scattered: bool,
    /// More than noise explains: by their scatter, or by what is the same in all of them.
    pub beyond_noise: bool,
    /// What is the same in all of them: ahead, left, turned.
    pub drifts: [Drift; 3],
}

impl Cell {
    /// The systematic error that stands out most.
    pub fn main_drift(&self) -> Drift {
        let first = self.drifts[0];
        self.drifts.iter().copied().fold(first, |a, b| if b.sigmas() > a.sigmas() { b } else { a })
    }
}

/// Which label a step has, if any.
type Sorter<'a> = Box<dyn Fn(&PreparedRun, &Step) -> Option<usize> + 'a>;

/// The labels of a question: their names, and which one a step has.
struct Labels<'a> {
    name: &'static str,
    names: Vec<String>,
    of: Sorter<'a>,
}

/// All questions, each with the cells that have stretches.
pub(super) fn questions(
    prepared: &Prepared,
    terms: &[Term<'_>],
    noise: &OdometryNoise,
) -> Vec<Question> {
    let tracks = tracks(prepared, terms);
    labels(prepared)
        .into_iter()
        .filter_map(|labels| {
            let mut found: Vec<Vec<Stretch>> = vec![Vec::new(); labels.names.len()];
            for (index, (run, track)) in prepared.runs.iter().zip(&tracks).enumerate() {
                let label = |k: usize| (labels.of)(run, &run.motion.steps[k]);
                for (label, stretch) in stretches(index, run, track, noise, label) {
                    found[label].push(stretch);
                }
            }
            let there = found.iter().filter(|stretches| !stretches.is_empty()).count();
            let cells: Vec<Cell> = labels
                .names
                .into_iter()
                .zip(&found)
                .filter(|(_, stretches)| !stretches.is_empty())
                .map(|(name, stretches)| cell(name, stretches, there))
                .collect();
            // One cell alone answers no question, except that of the run kind.
            let tells = cells.len() > 1 || (labels.name == "run kind" && !cells.is_empty());
            tells.then_some(Question { name: labels.name, cells })
        })
        .collect()
}

fn cell(name: String, found: &[Stretch], cells: usize) -> Cell {
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
    // Noise is known to a few per cent only: a smaller excess does not count against the model.
    let excess = squares / NOISE_KNOWN_TO.powi(2);
    let drifts = Aspect::ALL.map(|aspect| drift(&all, aspect));
    let steady = drifts.iter().any(|drift| drift.sigmas() > DRIFT_SIGMAS);
    let scattered = chi_squared(3 * found.len(), excess) * (cells as f64) < FALSE_ALARM;
    Cell {
        name,
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

/// The labels of all questions.
fn labels(prepared: &Prepared) -> Vec<Labels<'_>> {
    vec![
        run_kind(prepared),
        path(),
        ramp_or_cruise(prepared),
        direction_of_travel(),
        turn_direction(),
        speed(prepared),
        heading(),
        wheel_angle("left wheel's angle", |step| step.phi_rad.left + step.dphi_rad.left / 2.0),
        wheel_angle("right wheel's angle", |step| step.phi_rad.right + step.dphi_rad.right / 2.0),
    ]
}

/// Labels whose names are known beforehand.
fn fixed<'a>(name: &'static str, names: &[&str], of: Sorter<'a>) -> Labels<'a> {
    Labels { name, names: names.iter().map(|name| (*name).to_owned()).collect(), of }
}

fn run_kind<'a>(prepared: &Prepared) -> Labels<'a> {
    let mut kinds: Vec<_> = prepared.runs.iter().map(|run| run.kind).collect();
    kinds.sort_unstable();
    kinds.dedup();
    Labels {
        name: "run kind",
        names: kinds.iter().map(ToString::to_string).collect(),
        of: Box::new(move |run, step| {
            moving(step).then(|| kinds.iter().position(|kind| *kind == run.kind)).flatten()
        }),
    }
}

fn path<'a>() -> Labels<'a> {
    let names = &["straight", "arc", "on the spot"];
    fixed("path", names, Box::new(|_, step| moving(step).then(|| path_of(step))))
}

fn ramp_or_cruise<'a>(prepared: &Prepared) -> Labels<'a> {
    let fastest = prepared
        .runs
        .iter()
        .map(|run| run.motion.steps.iter().map(rim_mps).fold(0.0, f64::max))
        .fold(0.0, f64::max);
    let ramp_mps2 = RAMP_MIN_MPS2.max(RAMP_SHARE_PER_S * fastest);
    let of = move |_: &PreparedRun, step: &Step| {
        let accel = step.wheel_accel_mps2.map(f64::abs);
        let ramp = accel.left.max(accel.right) > ramp_mps2;
        moving(step).then_some(usize::from(!ramp))
    };
    fixed("ramp or cruise", &["ramp", "cruise"], Box::new(of))
}

fn direction_of_travel<'a>() -> Labels<'a> {
    let of = |_: &PreparedRun, step: &Step| {
        let on_the_spot = path_of(step) == 2;
        (moving(step) && !on_the_spot).then(|| usize::from(step.speed_mps() < 0.0))
    };
    fixed("direction of travel", &["forward", "backward"], Box::new(of))
}

fn turn_direction<'a>() -> Labels<'a> {
    let of = |_: &PreparedRun, step: &Step| {
        let turning = path_of(step) > 0;
        (moving(step) && turning).then(|| usize::from(step.turn_rate_rad_s() < 0.0))
    };
    fixed("turn direction", &["left", "right"], Box::new(of))
}

fn speed<'a>(prepared: &Prepared) -> Labels<'a> {
    let edges = quantile_edges(prepared);
    Labels {
        name: "speed",
        names: speed_names(&edges),
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
    let of = move |_: &PreparedRun, step: &Step| {
        (moving(step) && path_of(step) < 2).then(|| facing(step.heading_rad))
    };
    let names = &["round 0 deg", "round 90 deg", "round 180 deg", "round 270 deg"];
    fixed("heading", names, Box::new(of))
}

fn wheel_angle<'a>(name: &'static str, angle_rad: fn(&Step) -> f64) -> Labels<'a> {
    let quadrant =
        |angle_rad: f64| (angle_rad.rem_euclid(TAU) / (TAU / 4.0)).floor().min(3.0) as usize;
    let of = move |_: &PreparedRun, step: &Step| moving(step).then(|| quadrant(angle_rad(step)));
    let names = &["0 to 90 deg", "90 to 180 deg", "180 to 270 deg", "270 to 360 deg"];
    fixed(name, names, Box::new(of))
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

/// Speeds that divide the steps of all runs into three parts, where they differ.
fn quantile_edges(prepared: &Prepared) -> Vec<f64> {
    let steps = prepared.runs.iter().flat_map(|run| &run.motion.steps);
    let mut speeds: Vec<f64> = steps.filter(|step| moving(step)).map(rim_mps).collect();
    if speeds.is_empty() {
        return Vec::new();
    }
    speeds.sort_by(f64::total_cmp);
    let mut edges =
        [0.33, 0.67].map(|share| speeds[(share * speeds.len() as f64) as usize]).to_vec();
    // Speeds that differ by less than a quarter count as one speed.
    edges.dedup_by(|b, a| *b < 1.25 * *a);
    edges
}

fn speed_names(edges: &[f64]) -> Vec<String> {
    let mut names = Vec::new();
    for k in 0..=edges.len() {
        names.push(match (k.checked_sub(1).map(|i| edges[i]), edges.get(k)) {
            (None, None) => "all".to_owned(),
            (None, Some(high)) => format!("below {high:.2} m/s"),
            (Some(low), Some(high)) => format!("{low:.2} to {high:.2} m/s"),
            (Some(low), None) => format!("above {low:.2} m/s"),
        });
    }
    names
}
