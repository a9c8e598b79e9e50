//! Recordings that cannot be what their columns say: other units, counters that went round, another clock.
//!
//! What the wheels rolled is held against what was measured. Between them lie slip, a wrong radius, a hand
//! that pushed, factors of one and a half at most; a wrong unit is a factor of 57 or more. Nothing here fires on a robot
//! that is merely wrong, and what stood still is never judged. What all runs say together, when the units
//! are right, is in `mismatch.rs`; what single poses do, in `end_pose.rs`.

use crate::kinematics::pose::Pose;
use crate::recording::run::{Recording, Robot};

use super::reckoning::{FAR_M, TURNED_RAD, at, of_side, reckon};

/// What a recording cannot be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Suspicion {
    /// Positions are in a smaller unit than metres.
    Positions {
        /// So many of it make a metre.
        per_m: f64,
        /// How far the robot would have got from where it was seen first \[m\].
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
    /// A counter went round.
    WentRound {
        /// Whether it is the right wheel's.
        right: bool,
        /// At the sample of this time \[s\].
        t_s: f64,
        /// Bits of the counter.
        bits: u32,
    },
    /// Time is in milliseconds or less.
    Clock {
        /// The fastest that a wheel would turn \[rad/s\].
        rate_rad_s: f64,
    },
}

/// Units that positions come in, by how many make a metre; and by what factor the wheels may disagree.
const UNITS_PER_M: [(f64, f64); 2] = [(1000.0, 2.5), (100.0, 1.6)];
/// A degree for a radian, and by what factor the wheels may disagree.
const DEGREES: (f64, f64) = (57.3, 1.9);
/// A step by nearly the whole range of a counter: to this share of it.
const ROUND: f64 = 0.125;
/// The step of a counter that went round is so many times faster than all others.
const ROUND_TIMES: f64 = 6.0;
/// Fewer other steps tell nothing of what is usual.
const STEPS_MIN: usize = 5;
/// A wheel that turned by a radian or more, and never faster than this \[rad/s\], by samples a second or
/// more apart: at 20 rad/s and a millisecond for a second.
const SLOW_RAD_S: f64 = 0.02;
/// Fewer samples may well be minutes apart.
const SAMPLES_MIN: usize = 20;

/// What is suspicious about a run; `run` is valid.
pub fn suspicions(robot: &Robot, run: &Recording) -> Vec<Suspicion> {
    let round: Vec<Suspicion> =
        [false, true].into_iter().filter_map(|right| went_round(robot, run, right)).collect();
    if !round.is_empty() {
        // Nothing that follows from the wheels means anything.
        return round;
    }
    let reckoned = reckon(robot, run);
    let found = [clock(run), positions(run, &reckoned), headings(run, &reckoned)];
    found.into_iter().flatten().collect()
}

fn within((value, factor): (f64, f64), ratio: f64) -> bool {
    (value / factor..=value * factor).contains(&ratio)
}

/// A step that is nearly the range of a counter of 16 or 32 bits, and faster than the wheel ever is.
fn went_round(robot: &Robot, run: &Recording, right: bool) -> Option<Suspicion> {
    let steps = || {
        run.wheels.windows(2).map(|pair| {
            let angle = |k: usize| of_side(pair[k].phi_rad, right);
            let counts = (angle(1) - angle(0)).abs() / robot.rad_per_count;
            (pair[1].t_s, counts, counts / (pair[1].t_s - pair[0].t_s))
        })
    };
    [16_u32, 32].into_iter().find_map(|bits| {
        let range = 2.0_f64.powi(bits as i32);
        let jumps = |counts: f64| (counts / range - 1.0).abs() < ROUND;
        let others: Vec<f64> =
            steps().filter(|(_, counts, _)| !jumps(*counts)).map(|(_, _, rate)| rate).collect();
        let usual = others.iter().copied().fold(0.0, f64::max);
        let (t_s, ..) = steps()
            .find(|(_, counts, rate)| jumps(*counts) && *rate > ROUND_TIMES * usual)
            .filter(|_| others.len() >= STEPS_MIN)?;
        Some(Suspicion::WentRound { right, t_s, bits })
    })
}

fn clock(run: &Recording) -> Option<Suspicion> {
    let mut spacings: Vec<f64> = run.wheels.windows(2).map(|it| it[1].t_s - it[0].t_s).collect();
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

/// Distances from where the robot was seen first: measured, and by its wheels.
fn positions(run: &Recording, reckoned: &[Pose]) -> Option<Suspicion> {
    let mut seen = run.measured_poses.iter().filter_map(|it| Some((it.position_m?, it.t_s)));
    let (first_m, first_s) = seen.next()?;
    let from = at(run, reckoned, first_s);
    let mut both: Vec<(f64, f64)> = seen
        .map(|([x_m, y_m], t_s)| {
            let there = at(run, reckoned, t_s);
            let rolled_m = (there.x_m - from.x_m).hypot(there.y_m - from.y_m);
            ((x_m - first_m[0]).hypot(y_m - first_m[1]), rolled_m)
        })
        .filter(|(_, rolled_m)| *rolled_m > FAR_M)
        .collect();
    // One stray picture is no unit: half of all must agree.
    both.sort_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)));
    let quarter = |of_four: usize| both.get((both.len().saturating_sub(1)) * of_four / 4).copied();
    let (low, middle, high) = (quarter(1)?, quarter(2)?, quarter(3)?);
    let unit = UNITS_PER_M
        .into_iter()
        .find(|unit| [low, high].iter().all(|(a, b)| within(*unit, a / b)))?;
    Some(Suspicion::Positions { per_m: unit.0, measured_m: middle.0, rolled_m: middle.1 })
}

/// Turns, as measured and by the wheels, one after the other over [`TURNED_RAD`] each.
fn headings(run: &Recording, reckoned: &[Pose]) -> Option<Suspicion> {
    let mut seen = run
        .measured_poses
        .iter()
        .filter_map(|it| Some((it.heading_rad?, at(run, reckoned, it.t_s).heading_rad)));
    let mut from = seen.next()?;
    let mut turns: Vec<(f64, f64)> = Vec::new();
    for (measured_rad, wheels_rad) in seen {
        let turned_rad = wheels_rad - from.1;
        if turned_rad.abs() > TURNED_RAD {
            turns.push((measured_rad - from.0, turned_rad));
            from = (measured_rad, wheels_rad);
        }
    }
    // Degrees that jump at 180 are few.
    turns.sort_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)));
    let (measured_rad, turned_rad) = *turns.get(turns.len() / 2)?;
    within(DEGREES, measured_rad / turned_rad).then_some(Suspicion::Headings {
        measured_rad: measured_rad.abs(),
        turned_rad: turned_rad.abs(),
    })
}
