//! Are the columns of a run in the units that they claim, without counters that overflow or another clock?
//!
//! The travel of the wheels is compared with the measured poses. Slip, a wrong radius or a push make a factor of
//! one and a half at most; a wrong unit makes one of 57 or more. A robot that is merely inaccurate passes, and
//! one that stands still is not tested. All runs together are tested in `mismatch.rs`, single poses in
//! `end_pose.rs`.

use crate::kinematics::pose::Pose;
use crate::recording::run::{Recording, Robot};

use super::dead_reckoning::{FAR_M, TURNED_RAD, at, of_side, reckon};

/// Why a recording cannot be right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Suspicion {
    /// Positions are in a smaller unit than metres.
    Positions {
        /// How many of this unit make a metre.
        per_m: f64,
        /// How far the robot would have got from its first measured position \[m\].
        measured_m: f64,
        /// How far from there its wheels took it \[m\].
        rolled_m: f64,
    },
    /// Headings are in degrees.
    Headings {
        /// How far the robot would have turned \[rad\].
        measured_rad: f64,
        /// How far its wheels turned it in the same time \[rad\].
        turned_rad: f64,
    },
    /// A counter overflowed.
    CounterOverflow {
        /// Whether it is the right wheel's.
        right: bool,
        /// At the sample of this time \[s\].
        t_s: f64,
        /// Bits of the counter.
        bits: u32,
    },
    /// Time is in milliseconds or a smaller unit.
    Clock {
        /// The fastest that a wheel would turn \[rad/s\].
        rate_rad_s: f64,
    },
}

/// Units of positions: how many make a metre, and by what factor the wheels may disagree.
const UNITS_PER_M: [(f64, f64); 2] = [(1000.0, 2.5), (100.0, 1.6)];
/// Degrees instead of radians: the factor, and by what factor the wheels may disagree.
const DEGREES: (f64, f64) = (57.3, 1.9);
/// An overflow is a step by the whole range of a counter, give or take this share.
const OVERFLOW_SHARE: f64 = 0.125;
/// The step of an overflow is this many times faster than all others.
const OVERFLOW_TIMES: f64 = 6.0;
/// Fewer other steps do not show what is usual.
const STEPS_MIN: usize = 5;
/// A clock in milliseconds makes wheels this slow, though they turn by a radian or more and samples are a second
/// or more apart: 20 rad/s, with a second for a millisecond \[rad/s\].
const SLOW_RAD_S: f64 = 0.02;
/// Fewer samples than these may really be minutes apart.
const SAMPLES_MIN: usize = 20;

/// What is suspicious about a run; `run` is valid.
pub fn suspicions(robot: &Robot, run: &Recording) -> Vec<Suspicion> {
    let overflows: Vec<Suspicion> =
        [false, true].into_iter().filter_map(|right| overflow(robot, run, right)).collect();
    if !overflows.is_empty() {
        // The other tests rely on the wheels.
        return overflows;
    }
    let reckoned = reckon(robot, run);
    let found = [clock(run), positions(run, &reckoned), headings(run, &reckoned)];
    found.into_iter().flatten().collect()
}

fn within((value, factor): (f64, f64), ratio: f64) -> bool {
    (value / factor..=value * factor).contains(&ratio)
}

/// A step that is nearly the range of a counter of 16 or 32 bits, and faster than the wheel ever is.
fn overflow(robot: &Robot, run: &Recording, right: bool) -> Option<Suspicion> {
    let steps = || {
        run.wheels.windows(2).map(|pair| {
            let angle = |k: usize| of_side(pair[k].phi_rad, right);
            let counts = (angle(1) - angle(0)).abs() / robot.rad_per_count;
            (pair[1].t_s, counts, counts / (pair[1].t_s - pair[0].t_s))
        })
    };
    [16_u32, 32].into_iter().find_map(|bits| {
        let range = 2.0_f64.powi(bits as i32);
        let jumps = |counts: f64| (counts / range - 1.0).abs() < OVERFLOW_SHARE;
        let others: Vec<f64> =
            steps().filter(|(_, counts, _)| !jumps(*counts)).map(|(_, _, rate)| rate).collect();
        let usual = others.iter().copied().fold(0.0, f64::max);
        let (t_s, ..) = steps()
            .find(|(_, counts, rate)| jumps(*counts) && *rate > OVERFLOW_TIMES * usual)
            .filter(|_| others.len() >= STEPS_MIN)?;
        Some(Suspicion::CounterOverflow { right, t_s, bits })
    })
}

fn clock(run: &Recording) -> Option<Suspicion> {
    let mut spacings: Vec<f64> =
        run.wheels.windows(2).map(|pair| pair[1].t_s - pair[0].t_s).collect();
    spacings.sort_by(f64::total_cmp);
    if run.wheels.len() < SAMPLES_MIN || spacings[spacings.len() / 2] < 1.0 {
        return None;
    }
    let (mut rate_rad_s, mut rolled_rad) = (0.0_f64, 0.0);
    for pair in run.wheels.windows(2) {
        let turned = pair[1].phi_rad.zip(pair[0].phi_rad).map(|(a, b)| (a - b).abs());
        let most = turned.left.max(turned.right);
        rate_rad_s = rate_rad_s.max(most / (pair[1].t_s - pair[0].t_s));
        rolled_rad += most;
    }
    (rolled_rad > 1.0 && rate_rad_s < SLOW_RAD_S).then_some(Suspicion::Clock { rate_rad_s })
}

/// Compares the measured distances from the first measured position with those by the wheels.
fn positions(run: &Recording, reckoned: &[Pose]) -> Option<Suspicion> {
    let poses = run.measured_poses.iter();
    let mut measured = poses.filter_map(|pose| Some((pose.position_m?, pose.t_s)));
    let (first_m, first_s) = measured.next()?;
    let from = at(run, reckoned, first_s);
    let mut both: Vec<(f64, f64)> = measured
        .map(|([x_m, y_m], t_s)| {
            let to = at(run, reckoned, t_s);
            let rolled_m = (to.x_m - from.x_m).hypot(to.y_m - from.y_m);
            ((x_m - first_m[0]).hypot(y_m - first_m[1]), rolled_m)
        })
        .filter(|(_, rolled_m)| *rolled_m > FAR_M)
        .collect();
    // A few wrong positions must not count as a unit: the middle half of all has to agree.
    both.sort_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)));
    let quarter = |of_four: usize| both.get((both.len().saturating_sub(1)) * of_four / 4).copied();
    let (low, middle, high) = (quarter(1)?, quarter(2)?, quarter(3)?);
    let unit = UNITS_PER_M
        .into_iter()
        .find(|unit| [low, high].iter().all(|(a, b)| within(*unit, a / b)))?;
    Some(Suspicion::Positions { per_m: unit.0, measured_m: middle.0, rolled_m: middle.1 })
}

/// Compares measured turns with those by the wheels, in consecutive pieces of more than [`TURNED_RAD`].
fn headings(run: &Recording, reckoned: &[Pose]) -> Option<Suspicion> {
    let mut headings = run
        .measured_poses
        .iter()
        .filter_map(|pose| Some((pose.heading_rad?, at(run, reckoned, pose.t_s).heading_rad)));
    let mut from = headings.next()?;
    let mut turns: Vec<(f64, f64)> = Vec::new();
    for (measured_rad, wheels_rad) in headings {
        let turned_rad = wheels_rad - from.1;
        if turned_rad.abs() > TURNED_RAD {
            turns.push((measured_rad - from.0, turned_rad));
            from = (measured_rad, wheels_rad);
        }
    }
    // The median, as only few turns contain a jump at 180 degrees.
    turns.sort_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)));
    let (measured_rad, turned_rad) = *turns.get(turns.len() / 2)?;
    within(DEGREES, measured_rad / turned_rad).then_some(Suspicion::Headings {
        measured_rad: measured_rad.abs(),
        turned_rad: turned_rad.abs(),
    })
}
