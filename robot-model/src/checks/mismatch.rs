//! Wheels and poses that cannot be of one robot, though each is in its units: a radius, a gear or a track width
//! off by a factor, a sign, two encoders exchanged.

use crate::numeric::angle::wrap;
use crate::recording::run::{PoseMeasurement, Recording, Robot};

use super::reckoning::{FAR_M, Reckoned, TURNED_RAD, at, median};

/// What cannot be, by the middle of all runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mismatch {
    /// On straight ways the robot got so many times as far as its wheels rolled.
    Travel {
        /// How many times.
        times: f64,
    },
    /// It went back where its wheels rolled ahead, and the other way round.
    Backwards,
    /// It turned so many times as far as its wheels turned it; negative is the other way round.
    Turns {
        /// How many times.
        times: f64,
    },
}

/// A robot that is merely wrong stays well within this factor; a diameter for a radius, or half the edges of an
/// encoder, is beyond it.
const FACTOR: f64 = 1.5;
/// A way is straight if it is at most so many times as long as what it led to, and by wheels and by eye
/// the robot turned by less than this \[rad\].
const STRAIGHT: (f64, f64) = (1.1, 0.5);
/// Turned by more between two poses, a wrapped heading may stand for another turn \[rad\].
const TURNED_MAX_RAD: f64 = 2.0;
/// Turned by less, wheels did not turn it \[rad\].
const TURNED_MIN_RAD: f64 = 1e-5;
/// What a campaign as a whole cannot be; its runs are valid, and none of them is suspicious.
pub fn mismatch(robot: &Robot, runs: &[Recording]) -> Option<Mismatch> {
    let (mut ways, mut turns) = (Vec::new(), Vec::new());
    for run in runs {
        let led = Reckoned::of(robot, run);
        ways.extend(median(led.ways()));
        turns.extend(median(led.turns()));
    }
    if let Some(times) = median(ways).filter(|it| !believable(*it)) {
        return Some(match believable(-times) {
            true => Mismatch::Backwards,
            false => Mismatch::Travel { times: times.abs() },
        });
    }
    let times = median(turns).filter(|it| !believable(*it))?;
    Some(Mismatch::Turns { times })
}

fn believable(times: f64) -> bool {
    (1.0 / FACTOR..=FACTOR).contains(&times)
}

impl Reckoned<'_> {
    /// On straight ways from where it was seen first: how far it got over how far its wheels took it;
    /// negative where it looked the other way.
    fn ways(&self) -> Vec<f64> {
        let mut seen = self.run.measured_poses.iter().filter_map(|it| Some((it, it.position_m?)));
        let Some((first, from_m)) = seen.next() else { return Vec::new() };
        let from = at(self.run, &self.poses, first.t_s);
        let ratio = |(measurement, to_m): (&PoseMeasurement, [f64; 2])| {
            let led = at(self.run, &self.poses, measurement.t_s).seen_from(from);
            let (led_m, way_m) =
                (led.x_m.hypot(led.y_m), self.rolled(first.t_s, measurement.t_s).0);
            let got_m = [to_m[0] - from_m[0], to_m[1] - from_m[1]];
            let far = led_m.max(got_m[0].hypot(got_m[1])) > FAR_M && led_m > 0.0;
            let turned = led.heading_rad.abs() > STRAIGHT.1;
            if !far || turned || way_m > STRAIGHT.0 * led_m {
                return None;
            }
            let times = got_m[0].hypot(got_m[1]) / led_m;
            let ahead = first.heading_rad.map_or(1.0, |heading_rad| {
                let along_m = got_m[0] * heading_rad.cos() + got_m[1] * heading_rad.sin();
                along_m * led.x_m.signum()
            });
            // Across, as with a heading that is off, it is neither.
            Some(if ahead < -0.5 * times * led_m { -times } else { times })
        };
        let straight = |it: &PoseMeasurement| {
            let turned_rad = first.heading_rad.zip(it.heading_rad).map(|(a, b)| wrap(b - a));
            turned_rad.is_none_or(|it| it.abs() < STRAIGHT.1)
        };
        // Once it turned it may look ahead again, but it is elsewhere.
        seen.take_while(|it| straight(it.0)).filter_map(ratio).collect()
    }

    /// How much it turned, bit by bit, over how much its wheels turned it.
    fn turns(&self) -> Vec<f64> {
        let heading = |it: &PoseMeasurement| {
            Some((it.heading_rad?, at(self.run, &self.poses, it.t_s).heading_rad))
        };
        let seen: Vec<(f64, f64)> = self.run.measured_poses.iter().filter_map(heading).collect();
        let (mut measured_rad, mut wheels_rad) = (0.0_f64, 0.0_f64);
        let mut ratios = Vec::new();
        for pair in seen.windows(2) {
            let by_wheels = pair[1].1 - pair[0].1;
            if by_wheels.abs() < TURNED_MAX_RAD {
                measured_rad += wrap(pair[1].0 - pair[0].0);
                wheels_rad += by_wheels;
                if measured_rad.abs().max(wheels_rad.abs()) < TURNED_RAD {
                    continue;
                }
                // Wheels that did not turn it at all say nothing of a factor.
                if wheels_rad.abs() > TURNED_MIN_RAD {
                    ratios.push(measured_rad / wheels_rad);
                }
            }
            (measured_rad, wheels_rad) = (0.0, 0.0);
        }
        ratios
    }
}
