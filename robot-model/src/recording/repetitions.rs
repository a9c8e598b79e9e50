//! Which runs are repetitions: the same motion by the recorded wheels, with the same load, from the same place.
//!
//! Names tell nothing: of `03_joy` and `08_joy` each may be a drive of its own.
//!
//! Along the path of both wheels since they began to move, s = (|ds_l| + |ds_r|) / 2, two runs are compared at so many
//! shares of it: how far each wheel went, and when.

use super::run::{PoseMeasurement, Recording, Robot};
use crate::numeric::angle::wrap;

/// Paths are compared at so many shares.
const SHARES: usize = 16;
/// How far a wheel went is the same within this share of its path, or this \[m\].
const SAME: (f64, f64) = (0.02, 0.005);
/// When it was there is the same within this share of the duration.
const SAME_TIME: f64 = 0.05;
/// A wheel moves from here on \[m\].
const MOVED_M: f64 = 0.003;
/// A run with a shorter path is no motion \[m\].
const PATH_MIN_M: f64 = 0.05;
/// The same place: position \[m\], heading \[rad\].
const PLACE: (f64, f64) = (0.2, 0.2);
/// The same load \[kg\].
const LOAD_KG: f64 = 0.05;

/// The number of each run's motion: runs with the same number repeat one another.
pub fn repetitions<'a>(robot: &Robot, runs: impl Iterator<Item = &'a Recording>) -> Vec<usize> {
    let mut firsts: Vec<Driven> = Vec::new();
    let number = |run: &'a Recording| {
        let driven = Driven::of(robot, run);
        firsts.iter().position(|first| first.is_repeated_by(&driven)).unwrap_or_else(|| {
            firsts.push(driven);
            firsts.len() - 1
        })
    };
    runs.map(number).collect()
}

/// How far both wheels had gone at a time since they began to move.
#[derive(Clone, Copy)]
struct Gone {
    t_s: f64,
    /// Forward less backward, left and right \[m\].
    net_m: [f64; 2],
    /// Forward and backward \[m\].
    path_m: [f64; 2],
}

impl Gone {
    fn middle_m(&self) -> f64 {
        (self.path_m[0] + self.path_m[1]) / 2.0
    }
}

/// What was driven in a run.
struct Driven {
    /// At equal shares of the path; none if the robot stood still.
    at_shares: Vec<Gone>,
    payload_kg: f64,
    begun: Option<PoseMeasurement>,
}

impl Driven {
    fn of(robot: &Robot, run: &Recording) -> Self {
        let gone = moving(robot, run);
        let whole_m = gone.last().map_or(0.0, Gone::middle_m);
        let at = |share: usize| {
            let wanted_m = whole_m * share as f64 / SHARES as f64;
            let next = gone.partition_point(|gone| gone.middle_m() < wanted_m);
            between(&gone, next.min(gone.len() - 1), wanted_m)
        };
        let at_shares =
            if whole_m < PATH_MIN_M { Vec::new() } else { (1..=SHARES).map(at).collect() };
        let begun = run.measured_poses.first().copied();
        Self { at_shares, payload_kg: run.payload_kg, begun }
    }

    fn is_repeated_by(&self, other: &Self) -> bool {
        let (Some(last), Some(other_last)) = (self.at_shares.last(), other.at_shares.last()) else {
            return false;
        };
        let late_s = SAME_TIME * last.t_s.max(other_last.t_s);
        let far_m = [0, 1].map(|wheel: usize| {
            (SAME.0 * last.path_m[wheel].max(other_last.path_m[wheel])).max(SAME.1)
        });
        let same = |(a, b): (&Gone, &Gone)| {
            let near = |wheel: usize| {
                let net_m = (a.net_m[wheel] - b.net_m[wheel]).abs();
                let path_m = (a.path_m[wheel] - b.path_m[wheel]).abs();
                net_m.max(path_m) <= far_m[wheel]
            };
            near(0) && near(1) && (a.t_s - b.t_s).abs() <= late_s
        };
        (self.payload_kg - other.payload_kg).abs() < LOAD_KG
            && is_same_place(self.begun.as_ref(), other.begun.as_ref())
            && self.at_shares.iter().zip(&other.at_shares).all(same)
    }
}

/// What was not measured may be the same.
fn is_same_place(a: Option<&PoseMeasurement>, b: Option<&PoseMeasurement>) -> bool {
    let (Some(a), Some(b)) = (a, b) else { return true };
    let position = a.position_m.zip(b.position_m);
    let heading = a.heading_rad.zip(b.heading_rad);
    position.is_none_or(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]) < PLACE.0)
        && heading.is_none_or(|(a, b)| wrap(a - b).abs() < PLACE.1)
}

/// The run from the last sample before a wheel moves to the first after which none does.
fn moving(robot: &Robot, run: &Recording) -> Vec<Gone> {
    let samples: Vec<(f64, [f64; 2])> = run
        .wheels
        .iter()
        .map(|sample| {
            let phi = sample.phi_rad;
            (sample.t_s, [phi.left, phi.right].map(|rad| rad * robot.wheel_radius_m))
        })
        .collect();
    let (Some(first), Some(last)) = (samples.first(), samples.last()) else { return Vec::new() };
    let moved = |from: &[f64; 2], to: &[f64; 2]| {
        (from[0] - to[0]).abs().max((from[1] - to[1]).abs()) > MOVED_M
    };
    let begin = samples.iter().position(|(_, at)| moved(&first.1, at)).unwrap_or(samples.len());
    let end = samples.iter().rposition(|(_, at)| moved(&last.1, at)).unwrap_or(0);
    let begin = begin.saturating_sub(1);
    let end = (end + 1).min(samples.len() - 1);
    if begin >= end {
        return Vec::new();
    }
    let (start_s, start_m) = samples[begin];
    let mut path_m = [0.0; 2];
    let mut before_m = start_m;
    let gone = samples[begin..=end].iter().map(|(t_s, at_m)| {
        for wheel in [0, 1] {
            path_m[wheel] += (at_m[wheel] - before_m[wheel]).abs();
        }
        before_m = *at_m;
        let net_m = [at_m[0] - start_m[0], at_m[1] - start_m[1]];
        Gone { t_s: t_s - start_s, net_m, path_m }
    });
    gone.collect()
}

/// Where the path was so long, between sample `next` and the one before it.
fn between(gone: &[Gone], next: usize, wanted_m: f64) -> Gone {
    let (b, a) = (gone[next], gone[next.saturating_sub(1)]);
    let step_m = b.middle_m() - a.middle_m();
    let share = if step_m > 0.0 { ((wanted_m - a.middle_m()) / step_m).min(1.0) } else { 1.0 };
    let mix = |a: f64, b: f64| a + share * (b - a);
    let both = |a: [f64; 2], b: [f64; 2]| [mix(a[0], b[0]), mix(a[1], b[1])];
    Gone { t_s: mix(a.t_s, b.t_s), net_m: both(a.net_m, b.net_m), path_m: both(a.path_m, b.path_m) }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;
    use crate::kinematics::wheel_pair::WheelPair;
    use crate::recording::run::WheelSample;

    const ROBOT: Robot = Robot::PAPER;

    /// A run whose wheels have gone so far \[m\] at a time since they began to move \[s\].
    fn driven(name: &str, rest_s: f64, gone_m: &dyn Fn(f64) -> [f64; 2]) -> Recording {
        let sample = |k: u32| {
            let t_s = 0.02 * f64::from(k);
            let rad = gone_m((t_s - rest_s).clamp(0.0, 10.0)).map(|m| {
                let counts = m / ROBOT.wheel_radius_m / ROBOT.rad_per_count;
                1.0 + counts.round() * ROBOT.rad_per_count
            });
            WheelSample { t_s, phi_rad: WheelPair::new(rad[0], rad[1]) }
        };
        Recording {
            name: name.into(),
            wheels: (0..700).map(sample).collect(),
            measured_poses: vec![PoseMeasurement {
                t_s: 0.0,
                position_m: Some([0.0, 0.0]),
                heading_rad: Some(0.0),
            }],
            ..Recording::default()
        }
    }

    fn numbers(runs: &[Recording]) -> Vec<usize> {
        repetitions(&ROBOT, runs.iter())
    }

    #[test]
    fn a_motion_driven_again_is_a_repetition_whatever_its_name_and_however_long_it_rested() {
        let arc = |t_s: f64| [0.2 * t_s, 0.3 * t_s];
        let nearly = |t_s: f64| [0.201 * t_s, 0.298 * t_s];
        let spin = |t_s: f64| [-0.1 * t_s, 0.1 * t_s];
        let rest = |_: f64| [0.0, 0.0];
        let runs = [
            driven("07_arc", 0.5, &arc),
            driven("anything", 2.0, &nearly),
            driven("07_arc_2", 0.5, &spin),
            driven("spin", 1.0, &spin),
            driven("rest", 0.0, &rest),
            driven("rest_2", 0.0, &rest),
        ];
        assert_eq!(numbers(&runs), [0, 0, 1, 1, 2, 3]);
    }

    #[test]
    fn drives_of_one_kind_that_differ_are_no_repetitions() {
        // The same ends after the same time, by other ways; and other lengths, radii and speeds.
        let wave = |times: f64| {
            move |t_s: f64| {
                let sway = 0.1 * (times * PI * t_s / 10.0).sin();
                [0.2 * t_s - sway, 0.2 * t_s + sway]
            }
        };
        let straight = |mps: f64| move |t_s: f64| [(mps * t_s).min(2.0); 2];
        let runs = [
            driven("01_joy", 0.5, &wave(2.0)),
            driven("02_joy", 0.5, &wave(4.0)),
            driven("03_joy", 0.5, &wave(-2.0)),
            driven("04_joy", 0.5, &straight(0.2)),
            driven("05_joy", 0.5, &straight(0.25)),
            driven("06_joy", 0.5, &straight(0.19)),
            driven("07_joy", 0.5, &straight(-0.2)),
        ];
        assert_eq!(numbers(&runs), [0, 1, 2, 3, 4, 5, 6]);
    }

    #[test]
    fn the_same_motion_with_another_load_or_from_another_place_is_no_repetition() {
        let arc = |t_s: f64| [0.2 * t_s, 0.3 * t_s];
        let mut runs = vec![driven("arc", 0.5, &arc); 5];
        runs[1].payload_kg = 2.0;
        runs[2].measured_poses[0].position_m = Some([1.0, 0.0]);
        runs[3].measured_poses[0].heading_rad = Some(PI / 2.0);
        runs[4].measured_poses[0] =
            PoseMeasurement { t_s: 0.0, position_m: Some([0.05, 0.0]), heading_rad: None };
        assert_eq!(numbers(&runs), [0, 1, 2, 3, 0]);
        runs[3].measured_poses.clear();
        assert_eq!(numbers(&runs), [0, 1, 2, 0, 0]);
    }
}
