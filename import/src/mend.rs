//! Mends what is certainly wrong with the frames and signs of a log, by what `robot-model` finds out from the motion, and
//! says so. What is wrong with the robot's numbers, or may be either of two things, is an error: a person has to say.

use robot_model::checks::{Axes, DataFault, DataHypothesis, Wheel, data_hypotheses};
use robot_model::clocks::align_roughly;
use robot_model::recording::{Campaign, Recording, Robot};

use std::f64::consts::PI;

use crate::angle::wrapped;

/// Something that only the user can decide.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Undecided {
    /// What is wrong.
    pub problem: String,
    /// What to do.
    pub hint: String,
}

/// Faults that hide others are mended one after the other; more than so many are none.
const ROUNDS: usize = 4;

/// Mends all runs alike; what was done, in words, and what is wrong with single runs. `one_reversed`: the speeds of wheels and poses
/// say that one wheel counts backwards.
pub fn mend(
    campaign: &mut Campaign,
    one_reversed: bool,
) -> Result<(Vec<String>, Vec<DataHypothesis>), Undecided> {
    let mut said = Vec::new();
    let reversed = reversed_wheel(&campaign.runs).filter(|_| one_reversed);
    if let Some(wheel) = reversed {
        said.push(change_sign(&mut campaign.runs, wheel));
    }
    let mut directions = Directions::of(&campaign.robot, &campaign.runs);
    if directions.both_backwards() {
        let wheels = campaign.runs.iter_mut().flat_map(|run| &mut run.wheels);
        wheels.for_each(|sample| sample.phi_rad = sample.phi_rad.map(|phi| -phi));
        said.push(
            "by the poses' headings both wheels count backwards: their signs were changed".into(),
        );
        directions = Directions::of(&campaign.robot, &campaign.runs);
    }
    if let Some(turned_rad) = directions.marker_rad() {
        headings(&mut campaign.runs, |rad| rad - turned_rad);
        said.push(format!(
            "headings are turned by {:+.1} degrees from the direction of travel, as by a marker mounted at an angle: corrected",
            turned_rad.to_degrees()
        ));
        if turned_rad.abs() > PI - BACKWARDS_RAD && reversed.is_some() {
            said.push(
                "a wheel that counts backwards and a marker back to front look the same as left and right exchanged, with \
                 the other wheel backwards: if they are, import again with the wheels exchanged"
                    .into(),
            );
        }
    }
    let mut of_runs = Vec::new();
    for round in 0..=ROUNDS {
        let found = data_hypotheses(&campaign.robot, &align_roughly(campaign).runs);
        let (all, single): (Vec<_>, Vec<_>) =
            found.into_iter().partition(|found| found.run.is_none());
        of_runs = single;
        let Some(worst) = all
            .into_iter()
            .find(|found| found.what != DataFault::Unknown && !found.what.is_minor())
        else {
            break;
        };
        if round == ROUNDS {
            return Err(Undecided {
                problem: "what is wrong with the axes of the poses cannot be told".into(),
                hint: "check that wheels and poses are of the same robot, and drive a square and a spin".into(),
            });
        }
        said.push(mend_all(&mut campaign.runs, &worst)?);
    }
    Ok((said, of_runs))
}

/// A shorter distance does not show a direction \[m\].
const FAR_M: f64 = 0.2;
/// On a straight path the wheels turn the robot by no more \[rad\].
const STRAIGHT_RAD: f64 = 0.03;
/// A smaller angle may be a drift or a crooked axle \[rad\].
const MARKER_MIN_RAD: f64 = 0.0175;
/// It takes so many straight stretches, whose angles agree so well: the length of their mean direction.
const STRETCHES_MIN: usize = 4;
const AGREE: f64 = 0.99;

/// Both wheels count backwards if headings point so nearly against the direction of travel \[rad\], and turns are so surely
/// turns the other way.
const BACKWARDS_RAD: f64 = 0.35;
const OPPOSITE: f64 = 0.9;

/// Where the headings point, by the wheels.
struct Directions {
    /// From the direction of travel to the heading, on straight stretches \[rad\].
    angles_rad: Vec<f64>,
    /// Turns by the headings times turns by the wheels, and the squares of both \[rad^2\].
    turns: [f64; 3],
}

impl Directions {
    fn of(robot: &Robot, runs: &[Recording]) -> Self {
        let mut directions = Self { angles_rad: Vec::new(), turns: [0.0; 3] };
        for run in runs {
            directions.add(robot, run);
        }
        directions
    }

    fn add(&mut self, robot: &Robot, run: &Recording) {
        let rolled_m = |t_s: f64| {
            let sample =
                run.wheels.partition_point(|sample| sample.t_s < t_s).min(run.wheels.len() - 1);
            run.wheels[sample].phi_rad.map(|phi| robot.wheel_radius_m * phi)
        };
        let mut from = None;
        for pose in &run.measured_poses {
            let (Some(position_m), Some(heading_rad)) = (pose.position_m, pose.heading_rad) else {
                continue;
            };
            let wheels_m = rolled_m(pose.t_s);
            let (from_m, [x_m, y_m], from_rad) =
                *from.get_or_insert((wheels_m, position_m, heading_rad));
            let travel = wheels_m.zip(from_m).map(|(to, from)| to - from);
            let turn_rad = travel.difference() / robot.track_width_m;
            let is_straight = turn_rad.abs() < STRAIGHT_RAD;
            let ahead_m = travel.mean();
            if is_straight && ahead_m.abs() < FAR_M {
                continue;
            }
            if is_straight {
                let (dx_m, dy_m) = (
                    (position_m[0] - x_m) * ahead_m.signum(),
                    (position_m[1] - y_m) * ahead_m.signum(),
                );
                self.angles_rad.push((heading_rad + from_rad) / 2.0 - dy_m.atan2(dx_m));
            } else {
                let turned_rad = heading_rad - from_rad;
                let [product, by_headings, by_wheels] = &mut self.turns;
                *product += turned_rad * turn_rad;
                *by_headings += turned_rad * turned_rad;
                *by_wheels += turn_rad * turn_rad;
            }
            from = Some((wheels_m, position_m, heading_rad));
        }
    }

    /// The angle from the direction of travel to the headings, if all straight stretches agree on one \[rad\].
    fn marker_rad(&self) -> Option<f64> {
        let angles_rad = &self.angles_rad;
        let (sin, cos) = angles_rad
            .iter()
            .fold((0.0, 0.0), |(sin, cos), rad| (sin + rad.sin(), cos + rad.cos()));
        let agree = sin.hypot(cos) / angles_rad.len().max(1) as f64;
        let mean_rad = sin.atan2(cos);
        // Of some headings that are elsewhere, the mean would make a marker.
        let from_mean = |rad: &f64| wrapped(rad - mean_rad);
        let mut off_rad: Vec<f64> = angles_rad.iter().map(from_mean).collect();
        off_rad.sort_by(f64::total_cmp);
        let turned_rad = mean_rad + off_rad.get(off_rad.len() / 2).copied().unwrap_or(0.0);
        let is_clear =
            angles_rad.len() >= STRETCHES_MIN && agree > AGREE && turned_rad.abs() > MARKER_MIN_RAD;
        is_clear.then_some(turned_rad)
    }

    /// Whether travel and turns both have the other sign: rather that of two counters than of a marker that sits back to front in
    /// mirrored axes.
    fn both_backwards(&self) -> bool {
        let points_back = self.marker_rad().is_some_and(|rad| rad.abs() > PI - BACKWARDS_RAD);
        let [product, by_headings, by_wheels] = self.turns;
        points_back && product < -OPPOSITE * (by_headings * by_wheels).sqrt() && product < 0.0
    }
}

fn mend_all(runs: &mut [Recording], found: &DataHypothesis) -> Result<String, Undecided> {
    let undecided = |problem: String, hint: &str| Err(Undecided { problem, hint: hint.into() });
    match found.what {
        DataFault::WheelsExchanged => {
            positions(runs, |[x, y]| [x, -y]);
            headings(runs, |rad| -rad);
            Ok("the tracker sees the robot turn the other way round than its wheels say: taken for axes that are mirrored, \
                z downwards; if instead left and right are exchanged, import again with the wheels exchanged, and if both wheels count \
                backwards, with their signs changed"
                .into())
        }
        // Which way is forwards, the wheels say.
        DataFault::CountsReversed { wheel: Wheel::Both } => {
            headings(runs, |rad| rad + PI);
            Ok("headings point backwards: turned by 180 degrees".into())
        }
        DataFault::CountsReversed { wheel } => Ok(change_sign(runs, wheel)),
        DataFault::Positions { per_m } => {
            positions(runs, |position| position.map(|part| part / per_m));
            Ok(format!("positions are in a unit of which {per_m:.4} make a metre: converted"))
        }
        DataFault::Axes { axes, after_first: false } => Ok(mend_axes(runs, axes)),
        DataFault::Counts { wheel, times } => undecided(
            format!("{} turned {times:.2} times as far as counted", name(wheel)),
            "check --counts-per-rev: four counts per line; both wheels need the same encoders",
        ),
        DataFault::Radius { times } => undecided(
            format!("the robot went {times:.2} times as far as its wheels rolled"),
            "correct --wheel-radius, --counts-per-rev or --gear-reduction",
        ),
        DataFault::Track { times } => undecided(
            format!("the robot turns as if its wheels were {times:.2} times as far apart"),
            "correct --track-width: the distance between the wheels' contact points",
        ),
        DataFault::Lengths { times } => undecided(
            format!("the wheels' radius and track width would both be {times:.2} times as large"),
            "give both in metres, or with a unit: --wheel-radius 36mm --track-width 37.2cm",
        ),
        _ => undecided(
            "the poses of all runs contradict the wheels, in a way that cannot be mended".into(),
            "check that wheels and poses are of the same robot",
        ),
    }
}

/// Changes the sign of one wheel.
fn change_sign(runs: &mut [Recording], wheel: Wheel) -> String {
    for sample in runs.iter_mut().flat_map(|run| &mut run.wheels) {
        match wheel {
            Wheel::Left => sample.phi_rad.left *= -1.0,
            _ => sample.phi_rad.right *= -1.0,
        }
    }
    let name = if wheel == Wheel::Left { "left" } else { "right" };
    format!("the {name} wheel counts backwards: its sign was changed")
}

/// Which wheel counts backwards, if one does and headings show it: with the left one reversed, the robot turns to the left by the
/// sum of both, and with the right one reversed to the right.
fn reversed_wheel(runs: &[Recording]) -> Option<Wheel> {
    let (mut product, mut by_headings, mut by_wheels) = (0.0, 0.0, 0.0);
    for run in runs {
        let sum_rad = |t_s: f64| {
            let after = run.wheels.partition_point(|sample| sample.t_s < t_s);
            let phi = run.wheels[after.min(run.wheels.len() - 1)].phi_rad;
            phi.left + phi.right
        };
        let poses = run.measured_poses.iter();
        let headings: Vec<(f64, f64)> =
            poses.filter_map(|pose| Some((sum_rad(pose.t_s), pose.heading_rad?))).collect();
        // Over a few frames, which are longer than noise and shorter than a corner.
        for pair in headings.windows(STRIDE + 1) {
            let turned_rad = pair[STRIDE].1 - pair[0].1;
            let sum_rad = pair[STRIDE].0 - pair[0].0;
            product += turned_rad * sum_rad;
            by_headings += turned_rad * turned_rad;
            by_wheels += sum_rad * sum_rad;
        }
    }
    let alike = product / (by_headings * by_wheels).sqrt().max(f64::MIN_POSITIVE);
    let wheel = if alike > 0.0 { Wheel::Left } else { Wheel::Right };
    (alike.abs() > ALIKE).then_some(wheel)
}

/// Headings over so many frames, and how alike turns have to be.
const STRIDE: usize = 5;
const ALIKE: f64 = 0.5;

fn mend_axes(runs: &mut [Recording], axes: Axes) -> String {
    match axes {
        Axes::XMirrored => {
            positions(runs, |[x, y]| [-x, y]);
            "x points the other way than headings say: its sign was changed".into()
        }
        Axes::YMirrored => {
            positions(runs, |[x, y]| [x, -y]);
            "y points the other way than headings say: its sign was changed".into()
        }
        Axes::Exchanged => {
            positions(runs, |[x, y]| [y, x]);
            "x and y are exchanged: changed back".into()
        }
        Axes::Heading { degrees, negated, turned_rad } => {
            let unit = if degrees { PI / 180.0 } else { 1.0 };
            let sign = if negated { -1.0 } else { 1.0 };
            headings(runs, |heading| sign * unit * heading - turned_rad);
            let unit = if degrees { ", are in degrees" } else { "" };
            let sign = if negated { ", count clockwise" } else { "" };
            let turned_deg = turned_rad.to_degrees();
            format!("headings are turned by {turned_deg:+.1} degrees{unit}{sign}: converted")
        }
        Axes::Frame { turned_rad } => {
            let (sin, cos) = turned_rad.sin_cos();
            positions(runs, |[x, y]| [cos * x + sin * y, cos * y - sin * x]);
            headings(runs, |heading| heading - turned_rad);
            format!(
                "positions and headings are turned by {:+.1} degrees: corrected",
                turned_rad.to_degrees()
            )
        }
    }
}

/// What is wrong with a single run, in words that follow "left out: ".
pub fn words(what: &DataFault) -> String {
    match what {
        DataFault::TrackerJump { t_s, by_m } => {
            format!("the tracker jumps by {by_m:.2} m at {t_s:.1} s")
        }
        DataFault::TrackerFrozen { from_s, to_s } => {
            format!("the tracker repeats one pose from {from_s:.1} s to {to_s:.1} s")
        }
        DataFault::CounterWraps { wheel, t_s, .. } => {
            format!("the counter of {} goes round at {t_s:.1} s", name(*wheel))
        }
        DataFault::CounterReset { wheel, t_s } => {
            format!("the counter of {} restarts at {t_s:.1} s", name(*wheel))
        }
        _ => "its poses contradict its wheels, unlike in the other runs".into(),
    }
}

fn name(wheel: Wheel) -> &'static str {
    match wheel {
        Wheel::Left => "the left wheel",
        Wheel::Right => "the right wheel",
        Wheel::Both => "both wheels",
    }
}

fn positions(runs: &mut [Recording], change: impl Fn([f64; 2]) -> [f64; 2]) {
    for pose in runs.iter_mut().flat_map(|run| &mut run.measured_poses) {
        pose.position_m = pose.position_m.map(&change);
    }
}

fn headings(runs: &mut [Recording], change: impl Fn(f64) -> f64) {
    for pose in runs.iter_mut().flat_map(|run| &mut run.measured_poses) {
        pose.heading_rad = pose.heading_rad.map(&change);
    }
}
